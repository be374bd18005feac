/* An FMU that tries what the sandbox must refuse: each line of resources/behaviour.txt is one
 * attempt. Its first line has the process, the folder and the terminal of a victim. What has worked
 * is printed. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <fmi2Functions.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

enum { VICTIM = -1000, SECRET, NEW, OTHER, OWN, FOREIGN, ROOT, HANDLE, TERMINAL, ZEROS };

static int victim, foreign;
static char secret[4200], new[4200], other[4200], root[4300], handle[64], terminal[64],
    own[] = "own";
static long zeros[64];

/* An attempt that is one system call; negative arguments from VICTIM on stand for what is above. */
typedef struct {
    const char *name;
    long number, arguments[6];
} Call;

static const Call calls[] = {
    {"read", SYS_openat, {AT_FDCWD, SECRET, O_RDONLY}},
    {"write", SYS_openat, {AT_FDCWD, SECRET, O_WRONLY | O_APPEND}},
    {"create", SYS_openat, {AT_FDCWD, NEW, O_CREAT | O_WRONLY, 0600}},
    {"handle", SYS_openat, {AT_FDCWD, SECRET, O_PATH}},
    {"delete", SYS_unlinkat, {AT_FDCWD, SECRET}},
    {"folder", SYS_mkdirat, {AT_FDCWD, NEW, 0700}},
    {"move", SYS_renameat2, {AT_FDCWD, SECRET, AT_FDCWD, OTHER}},
    {"take", SYS_renameat2, {AT_FDCWD, SECRET, AT_FDCWD, OWN}},
    {"link", SYS_linkat, {AT_FDCWD, SECRET, AT_FDCWD, OWN}},
    {"chmod", SYS_fchmodat, {AT_FDCWD, SECRET, 0777}},
    {"chmod_root", SYS_fchmodat, {AT_FDCWD, ROOT, 0777}},
    {"chmod_handle", SYS_fchmodat, {AT_FDCWD, HANDLE, 0644}},
    {"fchmod", SYS_fchmod, {FOREIGN, 0644}},
    {"futimens", SYS_utimensat, {FOREIGN}},
    {"flock", SYS_flock, {FOREIGN, LOCK_SH | LOCK_NB}},
    {"lease", SYS_fcntl, {FOREIGN, F_SETLEASE, F_RDLCK}},
    {"attributes", SYS_ioctl, {FOREIGN, 0x40086602, (long)zeros}},
    {"limits", SYS_prlimit64, {VICTIM, RLIMIT_NOFILE, ZEROS, 0}},
    {"kill", SYS_kill, {VICTIM, SIGTERM}},
    {"kill_all", SYS_kill, {-1, 0}},
    {"tgkill", SYS_tgkill, {VICTIM, VICTIM, SIGTERM}},
    {"priority", SYS_setpriority, {PRIO_PROCESS, VICTIM, 7}},
    {"priority_user", SYS_setpriority, {PRIO_USER, 0, 0}},
    {"terminal", SYS_openat, {AT_FDCWD, TERMINAL, O_RDONLY | O_NONBLOCK | O_NOCTTY}},
    {"own_terminal", SYS_openat, {AT_FDCWD, (long)"/dev/tty", O_RDONLY}},
    {"type", SYS_ioctl, {0, TIOCSTI, (long)"x"}},
    {"shared_file",
     SYS_openat,
     {AT_FDCWD, (long)"/dev/shm/stickslip-attempt", O_CREAT | O_RDWR, 0600}},
    {"datagrams", SYS_socketpair, {AF_UNIX, SOCK_DGRAM, 0, ZEROS}},
    {"unix_socket", SYS_socket, {AF_UNIX, SOCK_STREAM, 0}},
    {"internet", SYS_socket, {AF_INET, SOCK_STREAM, 0}},
    {"crypto", SYS_socket, {38, SOCK_SEQPACKET, 0}},
    {"io_uring", SYS_io_uring_setup, {1, ZEROS}},
    {"namespace", SYS_clone, {CLONE_NEWUSER | SIGCHLD}},
    {"group", SYS_setpgid, {0, 0}},
    {"program", SYS_execve, {(long)"/bin/true", ZEROS, ZEROS}},
    {"not_dumped", SYS_prctl, {PR_SET_DUMPABLE, 0}},
    {"unknown", 1000, {0}},
#ifdef __x86_64__
    {"x32", 0x40000000 | SYS_getpid, {0}},
#endif
};

static long value(long argument) {
    switch (argument) {
    case VICTIM:
        return victim;
    case SECRET:
        return (long)secret;
    case NEW:
        return (long)new;
    case OTHER:
        return (long)other;
    case OWN:
        return (long)own;
    case FOREIGN:
        return foreign;
    case ROOT:
        return (long)root;
    case HANDLE:
        return (long)handle;
    case TERMINAL:
        return (long)terminal;
    case ZEROS:
        return (long)zeros;
    default:
        return argument;
    }
}

static void *wait_long(void *nothing) {
    sleep(1000);
    return nothing;
}

static bool start_threads(void) {
    int n = 0;
    pthread_attr_t small;
    pthread_attr_init(&small);
    pthread_attr_setstacksize(&small, 1 << 16);
    for (pthread_t thread; n < 400 && !pthread_create(&thread, &small, wait_long, NULL); n++) {
    }
    return n >= 256;
}

static bool start_processes(void) {
    int n = 0;
    for (int child = 0; n < 400 && (child = fork()) >= 0; n++)
        if (child == 0)
            for (;;)
                pause();
    return n >= 256;
}

static bool share_memory(void) {
    int n = 0;
    for (int i = 0; i < 8; i++)
        n += mmap(NULL, 1 << 30, 3, MAP_SHARED | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
    return n > 4;
}

static volatile bool opened;
static void create(int number) {
    opened = opened || open(new, O_CREAT | O_WRONLY, number ? 0600 : 0) >= 0;
}

/* A thread that had begun before the sandbox would do it. */
static bool use_other_threads(void) {
    signal(SIGUSR1, create);
    for (int thread = getpid(); thread < getpid() + 50; thread++)
        syscall(SYS_tgkill, getpid(), thread, SIGUSR1);
    usleep(10000);
    return opened;
}

static bool send_to_an_address(void) {
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    int pair[2] = {-1, -1};
    snprintf(to.sun_path, sizeof to.sun_path, "%.90s", other);
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) || send(pair[0], "x", 1, 0) != 1)
        return true; /* what is allowed does not work */
    return sendto(pair[0], "x", 1, 0, (struct sockaddr *)&to, sizeof to) >= 0;
}

static bool know_environment(void) {
    char text[65536];
    FILE *file = fopen("/proc/self/environ", "r");
    const size_t n = file ? fread(text, 1, sizeof text, file) : 0;
    return getenv("SECRET_TOKEN") || n == 0 || memmem(text, n, "top secret", 10);
}

static bool raise_limits(void) {
    struct rlimit limit;
    getrlimit(RLIMIT_CORE, &limit);
    limit.rlim_max = limit.rlim_cur = limit.rlim_max + 1;
    return setrlimit(RLIMIT_CORE, &limit) == 0;
}

static bool change_own(void) { /* is said to work, though it does nothing */
    const int file = open("own", O_CREAT | O_RDWR, 0600);
    struct flock whole = {.l_type = F_WRLCK};
    return file < 0 || chmod("own", 0644) || fchmod(file, 0644) || flock(file, LOCK_EX) ||
           fcntl(file, F_SETLK, &whole) || futimens(file, NULL) || rename("own", "own2") ||
           link("own2", "own3") || unlink("own2") || unlink("own3") || close(file);
}

static bool call_as_32_bits(void) {
#ifdef __x86_64__
    long result = 20; /* getpid */
    __asm__ volatile("int $0x80" : "+a"(result) : : "memory", "r8", "r9", "r10", "r11");
    return result >= 0;
#else
    errno = EPERM;
    return false;
#endif
}

static const struct {
    const char *name;
    bool (*worked)(void);
} others[] = {
    {"threads", start_threads},      {"processes", start_processes},
    {"shared_memory", share_memory}, {"other_threads", use_other_threads},
    {"sendto", send_to_an_address},  {"environment", know_environment},
    {"raised_limits", raise_limits}, {"own_files", change_own},
    {"32_bits", call_as_32_bits},
};

/* Return whether it worked. */
static bool attempt(const char *name) {
    for (size_t i = 0; i < sizeof calls / sizeof *calls; i++) {
        if (strcmp(calls[i].name, name) == 0) {
            long a[6];
            for (int k = 0; k < 6; k++)
                a[k] = value(calls[i].arguments[k]);
            return syscall(calls[i].number, a[0], a[1], a[2], a[3], a[4], a[5]) >= 0;
        }
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (strcmp(others[i].name, name) == 0)
            return others[i].worked();
    }
    return true; /* there is no such attempt */
}

/* Carry out what a file asks for. */
static void try_all(const char *path) {
    char folder[4000], name[64];
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "%d %3999s %63s", &victim, folder, terminal) != 3)
        return;
    snprintf(secret, sizeof secret, "%s/secret", folder);
    snprintf(new, sizeof new, "%s/new", folder);
    snprintf(other, sizeof other, "%s/other", folder);
    snprintf(root, sizeof root, "/proc/self/root%s", secret);
    foreign = open("/etc/passwd", O_RDONLY);
    snprintf(handle, sizeof handle, "/proc/self/fd/%d", open("/etc/passwd", O_PATH));
    while (fscanf(file, "%63s", name) == 1) {
        if (attempt(name)) {
            printf("escaped: %s\n", name);
            fflush(stdout);
        }
    }
    fclose(file);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                              fmi2String resources, const fmi2CallbackFunctions *callbacks,
                              fmi2Boolean visible, fmi2Boolean logging) {
    static bool done;
    char path[4200];
    snprintf(path, sizeof path, "%.4000s/behaviour.txt", resources + strlen("file://"));
    if (!done)
        try_all(path);
    done = true;
    return NULL;
}
