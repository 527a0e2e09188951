// SPDX-License-Identifier: Apache-2.0
// Files that are written together: all of them are new, or all are as they were.
#include "output_file.h"

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <set>

#include "check.h"
#include "error.h"

namespace fs = std::filesystem;

namespace {

std::vector<char> bytes(const std::string &text) {
    return {text.begin(), text.end()};
}

std::string content(const fs::path &path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::set<std::string> names(const fs::path &folder) {
    std::set<std::string> result;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder))
        result.insert(entry.path().filename().string());
    return result;
}

bool fails(const std::vector<std::pair<fs::path, std::vector<char>>> &files) {
    try {
        write_files(files);
    } catch (const Error &) {
        return true;
    }
    return false;
}

// The file in `folder` that cannot be replaced is last, so that all others have been by then.
void check_failure_changes_nothing(const fs::path &folder) {
    const fs::path old = folder / "old.exr", blocked = folder / "blocked.png";
    write_files({{old, bytes("old")}});
    fs::create_directory(blocked);
    const std::set<std::string> before = names(folder);
    CHECK(fails({{old, bytes("new")}, {folder / "none.csv", bytes("new")}, {blocked, bytes("x")}}),
          "a folder was replaced by a file");
    CHECK(content(old) == "old", "'%s'", content(old).c_str());
    CHECK(names(folder) == before, "there are %zu files", names(folder).size());
    CHECK(fails({{old, bytes("new")}, {folder / "absent" / "x", bytes("x")}}), "no such folder");
    CHECK(content(old) == "old" && names(folder) == before, "'%s'", content(old).c_str());
    fs::remove(blocked);
    write_files({{old, bytes("new")}, {blocked, bytes("x")}});
    CHECK(content(old) == "new" && content(blocked) == "x", "'%s'", content(old).c_str());
    CHECK(names(folder) == before, "there are %zu files", names(folder).size());
}

void check_links_stay(const fs::path &folder) {
    fs::create_directory(folder / "deep");
    fs::create_symlink("deep/target", folder / "link");
    write_files({{folder / "link", bytes("through")}});
    CHECK(fs::is_symlink(folder / "link"), "the link was replaced");
    CHECK(content(folder / "deep" / "target") == "through", "elsewhere");
}

void check_same_file(const fs::path &folder) {
    write_files({{folder / "a", bytes("a")}, {folder / "b", bytes("a")}});
    fs::create_hard_link(folder / "a", folder / "hard");
    fs::create_symlink("a", folder / "soft");
    fs::create_symlink("new", folder / "soft-new");
    fs::create_symlink("loop", folder / "loop");
    fs::create_symlink(folder, folder / "here");
    const auto same = [&](const char *a, const char *b) {
        return is_same_file(folder / a, folder / b) && is_same_file(folder / b, folder / a);
    };
    CHECK(same("a", "a") && same("a", "hard") && same("a", "soft") && same("hard", "soft"), "a");
    CHECK(same("a", "here/a") && same("deep/../a", "here/here/soft"), "a");
    CHECK(same("new", "new") && same("new", "soft-new") && same("new", "here/new"), "new");
    CHECK(!same("a", "b") && !same("a", "new") && !same("new", "newer"), "different files");
    CHECK(!same("new", "deep/new") && !same("loop", "a") && !same("absent/a", "a"), "folders");
}

} // namespace

int main() {
    std::string name = (fs::temp_directory_path() / "bn-output-XXXXXX").string();
    CHECK(mkdtemp(name.data()), "no folder %s", name.c_str());
    const fs::path folder = name;
    check_failure_changes_nothing(folder);
    check_links_stay(folder);
    check_same_file(folder);
    fs::remove_all(folder);
    return 0;
}
