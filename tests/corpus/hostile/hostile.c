/* An FMU that does what resources/behaviour.txt says: "DoStep segv 3" crashes in the third step.
 * FMI 2.0 and FMI 3.0 in one library; y' = k u. With fragile set, a tenth of all k crash. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

enum { U, Y, K, FRAGILE, N_REALS, TIME = 99 };

typedef struct {
    double real[N_REALS], time;
    const fmi2CallbackFunctions *callbacks;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Model;

static char when[64], what[64], place[4096];
static int due = 1;
static Model *last;

static bool astray; /* messages come with an environment that the FMU was not given */

static void say(const Model *m, int status, const char *message) {
    if (m && m->callbacks) {
        m->callbacks->logger(astray ? (void *)1 : m->callbacks->componentEnvironment, "hostile",
                             (fmi2Status)status, "error", message);
    } else if (m && m->log) {
        m->log(astray ? (void *)1 : m->environment, (fmi3Status)status, "error", message);
    }
}

__attribute__((noinline)) static int overflow(volatile char *above) {
    volatile char here[4096];
    here[0] = above ? (char)(above[0] + 1) : 0;
    return overflow(here) + here[0];
}

static void *chat(void *m) {
    for (;;) {
        say(m, 3, "from outside");
        usleep(100);
    }
    return NULL;
}

static void leak(void) {
    for (;;) {
        volatile char *room = malloc(1 << 24);
        for (size_t i = 0; i < 1 << 24; i += 4096)
            room[i] = 1; /* also where there was none */
    }
}

static void ignore(int number) { (void)number; }

static void close_files(int n) {
    for (int i = 0; i < n; i++)
        close(i);
}

static void scribble(int n_files, const char *text, size_t n) {
    for (int i = 0; i < n_files; i++)
        (void)!write(i, text, n);
}

static void sleep_elsewhere(void) {
    if (fork() == 0)
        for (;;)
            sleep(1000);
}

/* To zero; arm64 has one bit for both. */
static void flush_subnormals(bool results, bool operands) {
#ifdef __x86_64__
    const unsigned bits = (results ? 0x8000U : 0U) | (operands ? 0x40U : 0U);
    __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | bits);
#elif defined __aarch64__
    unsigned long control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    control |= results || operands ? 1UL << 24 : 0UL;
    __asm__ volatile("msr fpcr, %0" : : "r"(control));
#endif
}

static void change(void) {
    const int ours[] = {SIGINT, SIGTERM, SIGSEGV, SIGFPE, SIGPIPE, SIGCHLD, SIGALRM};
    for (size_t i = 0; i < sizeof ours / sizeof *ours; i++)
        signal(ours[i], ignore);
}

/* What an FMU may return with; everything else does not return, or leaves something behind. */
static int act(Model *m) {
#define IF(name) if (strcmp(what, name) == 0)
    IF("segv") { *(volatile int *)8 = 1; }
    IF("abort") { abort(); }
    IF("exit0") { exit(0); }
    IF("overflow") { return overflow(NULL); }
    IF("hang") {
        for (volatile bool waiting = true; waiting;)
            sleep(60);
    }
    IF("leak") { leak(); }
    while (strcmp(what, "flood") == 0)
        puts("there is no end to what I have to say about every step that I was asked to make");
    while (strcmp(what, "flood_log") == 0)
        say(m, 1, "this step was almost too much for me");
    IF("last_words") {
        fputs("assertion failed: x > 0\n", stderr);
        abort();
    }
    IF("deaf") {
        change();
        raise(SIGSTOP);
    }
    IF("fork") { fork(); }
    IF("kill_parent") { return kill(getppid(), SIGKILL) ? 3 : 0; }
    IF("connect") { return socket(AF_INET, SOCK_STREAM, 0) < 0 ? 3 : 0; }
    IF("execute") { return system("true") != 0; }
    IF("read_home") { return open(getenv("HOME"), O_RDONLY) < 0 ? 3 : 0; }
    IF("share") { /* memory that RLIMIT_DATA does not count */
        for (size_t n = 1 << 24;; usleep(1000))
            memset(mmap(NULL, n, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0), 1, n);
    }
    IF("share_out") { /* memory, between processes that each take less than they may */
        for (int i = 0; i < 4; i++)
            if (fork() == 0)
                for (volatile char *room = malloc(6 << 23), *p = room;; p += 4096)
                    p < room + (6 << 23) ? *p = 1 : pause();
        sleep(10);
    }
    IF("fill") { /* files that are each shorter than they may be */
        static char block[1 << 20];
        for (char name[] = "a"; name[0] < 'f'; name[0]++)
            for (int i = 0, file = open(name, O_CREAT | O_WRONLY, 0600); i < 50; i++)
                (void)!write(file, memset(block, 1, sizeof block), sizeof block);
        sleep(10);
    }
    IF("daemon") { sleep_elsewhere(); }
    IF("daemon_segv") {
        sleep_elsewhere();
        *(volatile int *)8 = 1;
    }
    IF("rewrite") { /* the next one that is loaded does something else, of the same length */
        FILE *file = fopen(place, "r+");
        if (file) {
            fputs("DoStep abort  ", file);
            fclose(file);
        }
    }
    IF("chdir") { return chdir("/"); }
    IF("locale") { setlocale(LC_ALL, "C.UTF-8"); }
    IF("flush") { flush_subnormals(true, true); }
    IF("flush_results") { flush_subnormals(true, false); }
    IF("flush_operands") { flush_subnormals(false, true); }
    IF("round") { fesetround(FE_UPWARD); }
    IF("round_down") { fesetround(FE_DOWNWARD); }
    IF("round_to_zero") { fesetround(FE_TOWARDZERO); }
    IF("signals") { change(); }
    IF("close") { close_files(1024); }
    IF("close_standard") { close_files(3); }
    IF("scribble") { scribble(1024, "{\"error\": 1}{\"error\": 1}", 24); }
    IF("scribble_standard") { scribble(3, "what is printed", 15); }
    IF("scribble_lines") { scribble(1024, "\n5\n[]\n\xff\xfe\n", 9); }
    /* two bytes behind their length */
    IF("scribble_frame") { scribble(1024, "\2\0\0\0\0\0\0\0{}", 10); }
    IF("mumble") {
        scribble(1024, "\2\0\0", 3);
        sleep(1000);
    }
    IF("chat_astray") { astray = true; }
    if (strncmp(what, "chat", 4) == 0) {
        pthread_t thread;
        pthread_create(&thread, NULL, chat, m);
    }
    IF("fail_format") {
        say(m, 3, "50 %n of it failed %s");
        return 3;
    }
    IF("fail") {
        say(m, 3, "I do not want to");
        return 3;
    }
    return 0;
}

static int call(Model *m, const char *name) {
    return strcmp(when, name) == 0 && --due == 0 ? act(m) : 0;
}

/* The behaviour lies two folders above the library. */
__attribute__((constructor)) static void load(void) {
    Dl_info self;
    if (!dladdr((void *)load, &self) || strlen(self.dli_fname) > 4000)
        return;
    strcpy(place, self.dli_fname);
    for (int i = 0; i < 3; i++) {
        char *slash = strrchr(place, '/');
        if (slash)
            *slash = '\0';
    }
    strcat(place, "/resources/behaviour.txt");
    FILE *file = fopen(place, "r");
    if (file) {
        (void)!fscanf(file, "%60s %60s %d", when, what, &due);
        fclose(file);
    }
    call(NULL, "load");
}

__attribute__((destructor)) static void unload(void) { call(NULL, "unload"); }

static void start(Model *m) {
    const double reals[N_REALS] = {1.0, 0.0, 1.0, 0.0};
    memcpy(m->real, reals, sizeof reals);
}

static Model *instantiate(const char *token, const Model *face) {
    Model *m = calloc(1, sizeof *m);
    if (!m)
        return NULL;
    *m = *face;
    start(m);
    if (strcmp(when, "Instantiate") == 0 && --due == 0) {
        if (strcmp(what, "null") == 0)
            return NULL;
        if (strcmp(what, "say_null") == 0)
            return say(m, 3, "no licence"), NULL;
        if (strcmp(what, "garbage") == 0)
            return (Model *)(size_t)16;
        if (strcmp(what, "same") == 0 && last)
            return last;
        act(m);
    }
    if (strcmp(token, "hostile") != 0) {
        say(m, 3, "wrong token");
        free(m);
        return NULL;
    }
    return last = m;
}

static int step(Model *m, double t, double h) {
    const double place_of_k = 7.0 * m->real[K];
    const int status = call(m, "DoStep");
    if (m->real[FRAGILE] > 0.0 && t > 0.05 && place_of_k - floor(place_of_k) < 0.1)
        *(volatile int *)8 = 1;
    m->real[Y] += h * m->real[K] * m->real[U];
    m->time = t + h;
    return status;
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N_REALS)
            return 3;
        m->real[r[i]] = v[i];
    }
    return call(m, "SetReal");
}

static int get(Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N_REALS && r[i] != TIME)
            return 3;
        v[i] = r[i] == TIME ? m->time : m->real[r[i]];
    }
    return call(m, "GetReal");
}

#define MAKE                                                                                       \
    instantiate(token, &(Model){.callbacks = callbacks, .log = log, .environment = environment})
#define ENTER call(m, "EnterInitializationMode")
#define LEAVE call(m, "ExitInitializationMode")
#define TERMINATE call(m, "Terminate")
#define RESET (start(m), call(m, "Reset"))
#define FREE call(m, "FreeInstance"), free(m)
#define STEP step(m, t, h)
#include "fmu.h"
