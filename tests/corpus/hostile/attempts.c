/* An FMU that tries what the sandbox must refuse: each line of resources/behaviour.txt is one
 * attempt, by its name or as a system call, "NAME NUMBER ARGUMENTS". The first line is the folder
 * of a victim. What has worked is printed. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <fmi2Functions.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

static int foreign;
static char new[4200], other[4200], handle[64];
static long zeros[64];

/* =TEXT is a text; what only this process knows has a name. */
static long argument(const char *word) {
    return word[0] == '='                 ? (long)(word + 1)
           : strcmp(word, "foreign") == 0 ? foreign
           : strcmp(word, "handle") == 0  ? (long)handle
           : strcmp(word, "zeros") == 0   ? (long)zeros
                                          : strtol(word, NULL, 0);
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
static bool attempt(const char *line) {
    char words[8][512] = {"", "", "0", "0", "0", "0", "0", "0"};
    long a[6];
    const int n = sscanf(line, "%511s %511s %511s %511s %511s %511s %511s %511s", words[0],
                         words[1], words[2], words[3], words[4], words[5], words[6], words[7]);
    for (int k = 0; k < 6; k++)
        a[k] = argument(words[k + 2]);
    if (n > 1)
        return syscall(argument(words[1]), a[0], a[1], a[2], a[3], a[4], a[5]) >= 0;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (strcmp(others[i].name, words[0]) == 0)
            return others[i].worked();
    return true; /* there is no such attempt */
}

/* Carry out what a file asks for. */
static void try_all(const char *path) {
    char folder[4000], line[4000];
    FILE *file = fopen(path, "r");
    if (!file || fscanf(file, "%3999s ", folder) != 1)
        return;
    snprintf(new, sizeof new, "%s/new", folder);
    snprintf(other, sizeof other, "%s/other", folder);
    foreign = open("/etc/passwd", O_RDONLY);
    snprintf(handle, sizeof handle, "/proc/self/fd/%d", open("/etc/passwd", O_PATH));
    while (fgets(line, sizeof line, file)) {
        if (attempt(line)) {
            printf("escaped: %s\n", line);
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
