/* SPDX-License-Identifier: Apache-2.0
 * A program with elevated privileges ignores BN_ONNXRUNTIME.
 *
 * The test copies itself to a set-user-ID file owned by another user and runs the copy with the variable
 * set to the fake runtime, which must not be loaded. The test requires root and is skipped (77) otherwise. */
#define _DEFAULT_SOURCE
#include "check.h"
#include "neural.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { OTHER_USER = 65534, LOADED = 10, NOT_LOADED = 11, SAME_RIGHTS = 12 };

/* Opens a network as any program would. Returns whether this loaded the fake runtime. */
static int child(int expects_more_rights) {
    bn_neural *neural;
    if (expects_more_rights && getuid() == geteuid()) return SAME_RIGHTS;
    open_model(&plain, NULL, NULL, 1, &neural);
    bn_neural_close(neural);
    return dlopen(FAKE_RUNTIME, RTLD_NOW | RTLD_NOLOAD) != NULL ? LOADED : NOT_LOADED;
}

static int run(const char *program, const char *first, const char *second) {
    const pid_t process = fork();
    int status = -1;
    if (process == 0) {
        setenv("BN_ONNXRUNTIME", FAKE_RUNTIME, 1);
        execlp(program, program, first, second, (char *)NULL);
        _exit(1);
    }
    if (process < 0 || waitpid(process, &status, 0) != process) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int main(int argc, char **argv) {
    char copy[] = BN_FAKE_DIR "/test_neural_rights_copy";
    if (argc > 1) return child(strcmp(argv[1], "more") == 0);
    CHECK(run(argv[0], "same", NULL) == LOADED);
    if (geteuid() != 0) {
        printf("skipped: creating a set-user-ID copy requires root\n");
        return check_result() == 0 ? 77 : 1;
    }
    CHECK(run("cp", argv[0], copy) == 0 && chown(copy, OTHER_USER, OTHER_USER) == 0 &&
          chmod(copy, 06755) == 0);
    const int found = run(copy, "more", NULL);
    remove(copy);
    if (found == SAME_RIGHTS || found == 1) {
        printf("skipped: the file system does not allow set-user-ID programs\n");
        return check_result() == 0 ? 77 : 1;
    }
    CHECK(found == NOT_LOADED);
    return check_result();
}
