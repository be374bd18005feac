/* Loads the binary of a component. */
#ifndef COSIM_LIBRARY_H
#define COSIM_LIBRARY_H

#include <stddef.h>

/* Where FMI 2.0 and FMI 3.0 keep the binaries of this platform, and how they end. */
#if defined _WIN32
#define FOLDER2 "win64"
#define SYSTEM "windows"
#define SUFFIX ".dll"
#elif defined __APPLE__
#define FOLDER2 "darwin64"
#define SYSTEM "darwin"
#define SUFFIX ".dylib"
#else
#define FOLDER2 "linux64"
#define SYSTEM "linux"
#define SUFFIX ".so"
#endif
#ifdef __aarch64__
#define FOLDER3 "aarch64-" SYSTEM
#ifdef __linux__ /* FMI 2.0 has no name for it; macOS has universal libraries */
#undef FOLDER2
#define FOLDER2 FOLDER3
#endif
#else
#define FOLDER3 "x86_64-" SYSTEM
#endif

/* NULL with a reason when it cannot be loaded. */
void *library_open(const char *path, char *reason, size_t size);
void library_close(void *library);
void (*library_function(void *library, const char *name))(void);

/* The path that a file URI names; a path stays as it is. */
void path_of_uri(const char *uri, char *path, size_t size);
void uri_of_path(const char *path, char *uri, size_t size);

#endif
