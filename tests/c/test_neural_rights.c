/* SPDX-License-Identifier: Apache-2.0
 * A program with more rights than its user ignores BN_ONNXRUNTIME.
 *
 * Needs root: copies itself to a set-user-ID file of another user, and runs that with the variable
 * set to a library of the test, which must not be loaded. As any other user it is skipped (77). */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>

enum { OTHER_USER = 65534, LOADED = 10, NOT_LOADED = 11, SAME_RIGHTS = 12 };

/* Opens a network as any program would; says whether the library of the test was loaded for it. */
static int child(int expects_more_rights) {
    model_parts parts = model_parts_default();
    bn_neural *neural;
    if (expects_more_rights && getuid() == geteuid()) return SAME_RIGHTS;
    open_parts(&parts, NULL, 1, &neural);
    bn_neural_close(neural);
    return dlopen(FAKE_RUNTIME, RTLD_NOW | RTLD_NOLOAD) != NULL ? LOADED : NOT_LOADED;
}

static int run(const char *program, const char *argument) {
    const pid_t process = fork();
    int status = -1;
    if (process == 0) {
        setenv("BN_ONNXRUNTIME", FAKE_RUNTIME, 1);
        execl(program, program, argument, (char *)NULL);
        _exit(1);
    }
    if (process < 0 || waitpid(process, &status, 0) != process) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static int copy_file(const char *from, const char *to) {
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    char bytes[65536];
    size_t got = 0;
    int good = in != NULL && out != NULL;
    while (good && (got = fread(bytes, 1, sizeof bytes, in)) > 0) {
        good = fwrite(bytes, 1, got, out) == got;
    }
    if (in != NULL) fclose(in);
    if (out != NULL && fclose(out) != 0) good = 0;
    return good;
}

int main(int argc, char **argv) {
    char copy[] = BN_FAKE_DIR "/test_neural_rights_copy";
    if (argc > 1) return child(strcmp(argv[1], "more") == 0);
    CHECK(run(argv[0], "same") == LOADED);
    if (geteuid() != 0) {
        printf("not root: a set-user-ID copy cannot be made\n");
        return check_result() == 0 ? 77 : 1;
    }
    CHECK(copy_file(argv[0], copy) && chown(copy, OTHER_USER, OTHER_USER) == 0 &&
          chmod(copy, 06755) == 0);
    const int found = run(copy, "more");
    remove(copy);
    if (found == SAME_RIGHTS || found == 1) {
        printf("the file system does not allow set-user-ID programs\n");
        return check_result() == 0 ? 77 : 1;
    }
    CHECK(found == NOT_LOADED);
    return check_result();
}
