/* Kills a process, or simulates a full disk, at the n-th call that changes a file below a folder.
 *
 * Preloaded by failpoints.py. Environment:
 *   FAIL_UNDER  absolute path of the folder; only calls on paths below it, or on files opened there, are counted
 *   FAIL_AT     number of the call, from 1; 0 or absent: none
 *   FAIL_HOW    before: killed before the call;  after: killed after it;  torn: killed after half of a write;
 *               full: this call and all later ones that need space fail with "no space left on device";
 *               existing bytes of a file may be overwritten
 *   FAIL_COUNT  file that receives the number of calls when the process ends
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum how { NEVER, BEFORE, AFTER, TORN, FULL };

static const char *under;
static long target;
static enum how how;
static atomic_long calls;
static atomic_bool watched[4096];

__attribute__((constructor)) static void begin(void) {
    under = getenv("FAIL_UNDER");
    const char *at = getenv("FAIL_AT");
    const char *word = getenv("FAIL_HOW");
    target = at ? atol(at) : 0;
    how = !word || !target          ? NEVER
          : !strcmp(word, "before") ? BEFORE
          : !strcmp(word, "after")  ? AFTER
          : !strcmp(word, "torn")   ? TORN
          : !strcmp(word, "full")   ? FULL
                                    : NEVER;
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAIL_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (file) {
        fprintf(file, "%ld\n", atomic_load(&calls));
        fclose(file);
    }
}

static int is_under(const char *path) {
    return under && path && !strncmp(path, under, strlen(under));
}

static int is_watched(int fd) {
    return fd >= 0 && fd < 4096 && atomic_load(&watched[fd]);
}

static void watch(int fd, int yes) {
    if (fd >= 0 && fd < 4096) atomic_store(&watched[fd], yes);
}

/* Counts a call and returns whether it is the target. */
static int counts(void) {
    long number = atomic_fetch_add(&calls, 1) + 1;
    if (how == FULL) return number >= target;
    int hit = how != NEVER && number == target;
    if (hit && how == BEFORE) kill(getpid(), SIGKILL);
    return hit;
}

static void after(int hit) {
    if (hit && how != FULL) kill(getpid(), SIGKILL);
}

static int no_space(int hit) {
    if (!hit || how != FULL) return 0;
    errno = ENOSPC;
    return 1;
}

/* Returns whether a write extends a file; overwriting needs no space. */
static int grows(int fd, off64_t end) {
    struct stat64 facts;
    return fstat64(fd, &facts) || end > facts.st_size;
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

#define OPEN(name)                                                                            \
    int name(const char *path, int flags, ...) {                                              \
        mode_t mode = 0;                                                                      \
        if (flags & O_CREAT) {                                                                \
            va_list rest;                                                                     \
            va_start(rest, flags);                                                            \
            mode = va_arg(rest, mode_t);                                                      \
            va_end(rest);                                                                     \
        }                                                                                     \
        int counted = is_under(path) && (flags & O_CREAT);                                    \
        int hit = counted && counts();                                                        \
        if (no_space(hit)) return -1;                                                          \
        int fd = REAL(name)(path, flags, mode);                                               \
        watch(fd, is_under(path));                                                            \
        after(hit);                                                                           \
        return fd;                                                                            \
    }
OPEN(open)
OPEN(open64)

#define OPEN_AT(name)                                                                         \
    int name(int folder, const char *path, int flags, ...) {                                  \
        mode_t mode = 0;                                                                      \
        if (flags & O_CREAT) {                                                                \
            va_list rest;                                                                     \
            va_start(rest, flags);                                                            \
            mode = va_arg(rest, mode_t);                                                      \
            va_end(rest);                                                                     \
        }                                                                                     \
        int below = is_under(path) || is_watched(folder);                                     \
        int hit = below && (flags & O_CREAT) && counts();                                     \
        if (no_space(hit)) return -1;                                                          \
        int fd = REAL(name)(folder, path, flags, mode);                                       \
        watch(fd, below);                                                                     \
        after(hit);                                                                           \
        return fd;                                                                            \
    }
OPEN_AT(openat)
OPEN_AT(openat64)

int close(int fd) {
    watch(fd, 0);
    return REAL(close)(fd);
}

/* Duplicates a descriptor, which stays watched. */
int fcntl64(int fd, int command, ...) {
    va_list rest;
    va_start(rest, command);
    void *argument = va_arg(rest, void *);
    va_end(rest);
    int result = REAL(fcntl64)(fd, command, argument);
    if (command == F_DUPFD || command == F_DUPFD_CLOEXEC) watch(result, is_watched(fd));
    return result;
}

ssize_t write(int fd, const void *bytes, size_t length) {
    int hit = is_watched(fd) && counts();
    if (hit && how == FULL && grows(fd, lseek64(fd, 0, SEEK_CUR) + (off64_t)length) && no_space(hit)) return -1;
    ssize_t done = REAL(write)(fd, bytes, hit && how == TORN ? length / 2 : length);
    after(hit);
    return done;
}

#define PWRITE(name, offset_type)                                                             \
    ssize_t name(int fd, const void *bytes, size_t length, offset_type offset) {              \
        int hit = is_watched(fd) && counts();                                                 \
        if (hit && how == FULL && grows(fd, offset + (off64_t)length) && no_space(hit)) return -1; \
        ssize_t done = REAL(name)(fd, bytes, hit && how == TORN ? length / 2 : length, offset); \
        after(hit);                                                                           \
        return done;                                                                          \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

#define ON_FILE(name, needs_space, ...)                                                        \
    {                                                                                         \
        int hit = is_watched(fd) && counts();                                                 \
        if (needs_space && no_space(hit)) return -1;                                            \
        int result = REAL(name)(__VA_ARGS__);                                                 \
        after(hit);                                                                           \
        return result;                                                                        \
    }
int fsync(int fd) ON_FILE(fsync, 1, fd)
int fdatasync(int fd) ON_FILE(fdatasync, 1, fd)
int ftruncate(int fd, off_t length) ON_FILE(ftruncate, 0, fd, length)
int ftruncate64(int fd, off64_t length) ON_FILE(ftruncate64, 0, fd, length)

#define ON_PATH(name, needs_space, ...)                                                        \
    {                                                                                         \
        int hit = is_under(path) && counts();                                                 \
        if (needs_space && no_space(hit)) return -1;                                            \
        int result = REAL(name)(__VA_ARGS__);                                                 \
        after(hit);                                                                           \
        return result;                                                                        \
    }
int rename(const char *path, const char *to) ON_PATH(rename, 0, path, to)
int unlink(const char *path) ON_PATH(unlink, 0, path)
int rmdir(const char *path) ON_PATH(rmdir, 0, path)
int mkdir(const char *path, mode_t mode) ON_PATH(mkdir, 1, path, mode)

int unlinkat(int folder, const char *path, int flags) {
    int hit = (is_under(path) || is_watched(folder)) && counts();
    int result = REAL(unlinkat)(folder, path, flags);
    after(hit);
    return result;
}
