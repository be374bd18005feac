#include "library.h"
#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>

void *library_open(const char *path, char *reason, size_t size) {
    wchar_t wide[4096];
    MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096);
    for (wchar_t *c = wide; *c; c++)
        *c = *c == L'/' ? L'\\' : *c;
    void *library = LoadLibraryExW(wide, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
    if (!library)
        snprintf(reason, size, "%s: error %lu of Windows", path, GetLastError());
    return library;
}

void library_close(void *library) { FreeLibrary(library); }

void (*library_function(void *library, const char *name))(void) {
    return (void (*)(void))GetProcAddress(library, name);
}
#else
#include <dlfcn.h>

void *library_open(const char *path, char *reason, size_t size) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        snprintf(reason, size, "%s", dlerror());
    return library;
}

void library_close(void *library) { dlclose(library); }

void (*library_function(void *library, const char *name))(void) {
    void *found = dlsym(library, name);
    void (*function)(void);
    memcpy(&function, &found, sizeof function);
    return function;
}
#endif

void path_of_uri(const char *uri, char *path, size_t size) {
    const bool is_uri = strncmp(uri, "file:", 5) == 0;
    const char *from = is_uri ? uri + 5 : uri;
    if (is_uri && strncmp(from, "//", 2) == 0) /* an empty host or localhost, then the path */
        from = strchr(from + 2, '/') ? strchr(from + 2, '/') : from + 2;
    if (is_uri && from[0] == '/' && isalpha((unsigned char)from[1]) && from[2] == ':')
        from++;
    size_t n = 0;
    for (; *from && n + 1 < size; from++) {
        char code[3] = {0};
        if (is_uri && *from == '%' && isxdigit((unsigned char)from[1]) &&
            isxdigit((unsigned char)from[2])) {
            memcpy(code, from + 1, 2);
            from += 2;
            path[n++] = (char)strtol(code, NULL, 16);
        } else {
            path[n++] = *from;
        }
    }
    while (n > 1 && (path[n - 1] == '/' || path[n - 1] == '\\'))
        n--;
    path[n] = '\0';
}

void uri_of_path(const char *path, char *uri, size_t size) {
    size_t n = (size_t)snprintf(uri, size, "file://%s", path[0] == '/' ? "" : "/");
    for (; *path && n + 4 < size; path++) {
        const unsigned char c = (unsigned char)*path;
        if (isalnum(c) || strchr("-._~/:", c))
            uri[n++] = *path;
        else if (c == '\\')
            uri[n++] = '/';
        else
            n += (size_t)snprintf(uri + n, size - n, "%%%02X", c);
    }
    uri[n] = '\0';
}
