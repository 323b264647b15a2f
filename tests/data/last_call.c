/* A process that ends at one of its calls: at the call of the number LAST_CALL, counted from 0, it gets the signal LAST_SIGNAL before
   the call is made. Counted are the calls of the C library that name a file, and those that write or synchronise one. At a normal end
   the number of calls is written to the file LAST_COUNT. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;
static long last = -1;
static int with = SIGKILL;

__attribute__((constructor)) static void begin(void) {
    const char *number = getenv("LAST_CALL"), *signal = getenv("LAST_SIGNAL");
    if (number) last = atol(number);
    if (signal) with = atoi(signal);
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("LAST_COUNT");
    char text[32];
    int length = snprintf(text, sizeof text, "%ld", atomic_load(&calls));
    int file = path ? (int)syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0644) : -1;
    if (file >= 0) syscall(SYS_write, file, text, length);
}

/* A handler of the signal has run when this returns: it goes to the thread that calls. */
static void count(void) {
    if (atomic_fetch_add(&calls, 1) == last) raise(with);
}

#define REAL(type, name, parameters) \
    static type(*real) parameters; \
    if (!real) real = (type(*) parameters)dlsym(RTLD_NEXT, #name)

#define CALL(type, name, parameters, arguments) \
    type name parameters { REAL(type, name, parameters); count(); return real arguments; }

/* The mode is there where a file may be made, and is handed on unread otherwise. */
#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        REAL(int, name, (const char *, int, ...)); \
        va_list rest; va_start(rest, flags); int mode = va_arg(rest, int); va_end(rest); \
        count(); return real(path, flags, mode); }
#define OPENAT(name) \
    int name(int at, const char *path, int flags, ...) { \
        REAL(int, name, (int, const char *, int, ...)); \
        va_list rest; va_start(rest, flags); int mode = va_arg(rest, int); va_end(rest); \
        count(); return real(at, path, flags, mode); }

OPEN(open)
OPEN(open64)
OPENAT(openat)
OPENAT(openat64)
CALL(int, rename, (const char *a, const char *b), (a, b))
CALL(int, renameat, (int f, const char *a, int t, const char *b), (f, a, t, b))
CALL(int, renameat2, (int f, const char *a, int t, const char *b, unsigned flags), (f, a, t, b, flags))
CALL(int, link, (const char *a, const char *b), (a, b))
CALL(int, linkat, (int f, const char *a, int t, const char *b, int flags), (f, a, t, b, flags))
CALL(int, symlink, (const char *a, const char *b), (a, b))
CALL(int, symlinkat, (const char *a, int t, const char *b), (a, t, b))
CALL(int, unlink, (const char *a), (a))
CALL(int, unlinkat, (int f, const char *a, int flags), (f, a, flags))
CALL(int, mkdir, (const char *a, mode_t mode), (a, mode))
CALL(int, mkdirat, (int f, const char *a, mode_t mode), (f, a, mode))
CALL(int, rmdir, (const char *a), (a))
CALL(int, chmod, (const char *a, mode_t mode), (a, mode))
CALL(int, truncate64, (const char *a, off64_t length), (a, length))
CALL(int, stat64, (const char *a, struct stat64 *s), (a, s))
CALL(int, lstat64, (const char *a, struct stat64 *s), (a, s))
CALL(int, statx, (int f, const char *a, int flags, unsigned mask, struct statx *s), (f, a, flags, mask, s))
CALL(int, access, (const char *a, int mode), (a, mode))
CALL(ssize_t, readlink, (const char *a, char *to, size_t size), (a, to, size))
CALL(char *, realpath, (const char *a, char *to), (a, to))
CALL(DIR *, opendir, (const char *a), (a))
CALL(int, ftruncate64, (int f, off64_t length), (f, length))
CALL(int, fsync, (int f), (f))
CALL(int, fdatasync, (int f), (f))
CALL(ssize_t, write, (int f, const void *bytes, size_t size), (f, bytes, size))
CALL(ssize_t, writev, (int f, const struct iovec *parts, int number), (f, parts, number))
