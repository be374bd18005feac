/* The state of a container: its own, and those of its components. */
#include "inside.h"
#include <stdlib.h>
#include <string.h>

typedef struct {
    Phase phase;
    int64_t done;
    double start, stop;
    double rows[2 * WIDTH];
} Own;

typedef struct {
    Own own;
    void *parts[N_PARTS];
} State;

#define ON_EACH_PART(call)                                                                         \
    for (int i = 0; i < N_PARTS; i++) {                                                            \
        const int status = (call);                                                                 \
        if (status > WARNING) {                                                                    \
            return part_failed(x, i, __func__, status);                                            \
        }                                                                                          \
    }
#define REQUIRE_ALIVE                                                                              \
    PLAIN_HERE;                                                                                    \
    if (instance_require(x, ALIVE, __func__) != OK) {                                              \
        return ERROR;                                                                              \
    }
/* A call that an FMU lacks fails. */
#define ON_PART(name, ...)                                                                         \
    (x->access[i].name ? x->access[i].name(x->components[i].instance, __VA_ARGS__) : ERROR)

static Status none(Instance *x) {
    return report(x, ERROR, "there is no state, or it is of another container");
}

Status instance_save(Instance *x, void **state) {
    REQUIRE_ALIVE
    State *s = *state ? *state : calloc(1, sizeof *s);
    if (!s)
        return report(x, ERROR, "there is no memory left to save the state");
    *state = s;
    s->own.phase = x->phase;
    s->own.done = x->run.done;
    s->own.start = x->run.start;
    s->own.stop = x->run.stop;
    memcpy(s->own.rows, x->rows, sizeof x->rows);
    ON_EACH_PART(ON_PART(save, &s->parts[i]))
    return OK;
}

Status instance_restore(Instance *x, const void *state) {
    REQUIRE_ALIVE
    const State *s = state;
    if (!s)
        return none(x);
    ON_EACH_PART(ON_PART(restore, s->parts[i]))
    x->phase = s->own.phase;
    x->stale = x->phase == INITIALIZATION;
    x->run.done = s->own.done;
    x->run.start = s->own.start;
    x->run.stop = s->own.stop;
    memcpy(x->rows, s->own.rows, sizeof x->rows);
    return OK;
}

Status instance_forget(Instance *x, void **state) {
    PLAIN_HERE;
    State *s = state ? *state : NULL;
    if (s) {
        ON_EACH_PART(ON_PART(forget, &s->parts[i]))
        free(s);
        *state = NULL;
    }
    return OK;
}

/* As bytes: token, own state, then for each part its size and its bytes. */
Status instance_serialized_size(Instance *x, const void *state, size_t *size) {
    REQUIRE_ALIVE
    const State *s = state;
    if (!s)
        return none(x);
    size_t sizes[N_PARTS];
    ON_EACH_PART(ON_PART(size, s->parts[i], &sizes[i]))
    *size = sizeof TOKEN + sizeof s->own;
    for (int i = 0; i < N_PARTS; i++)
        *size += sizeof sizes[i] + sizes[i];
    return OK;
}

Status instance_serialize(Instance *x, const void *state, uint8_t *bytes, size_t size) {
    REQUIRE_ALIVE
    const State *s = state;
    size_t needed = 0;
    const Status sized = instance_serialized_size(x, state, &needed);
    if (sized != OK || needed > size) {
        return sized != OK ? sized
                           : report(x, ERROR, "the state needs %zu bytes, got %zu", needed, size);
    }
    memcpy(bytes, TOKEN, sizeof TOKEN);
    memcpy(bytes + sizeof TOKEN, &s->own, sizeof s->own);
    bytes += sizeof TOKEN + sizeof s->own;
    for (int i = 0; i < N_PARTS; i++) {
        size_t one = 0;
        int status = ON_PART(size, s->parts[i], &one);
        memcpy(bytes, &one, sizeof one);
        bytes += sizeof one;
        status = status > WARNING ? status : ON_PART(pack, s->parts[i], bytes, one);
        if (status > WARNING)
            return part_failed(x, i, __func__, status);
        bytes += one;
    }
    return OK;
}

static Status unpack_parts(Instance *x, const uint8_t *bytes, const uint8_t *end, State *s) {
    for (int i = 0; i < N_PARTS; i++) {
        size_t size = 0;
        if ((size_t)(end - bytes) < sizeof size)
            return none(x);
        memcpy(&size, bytes, sizeof size);
        bytes += sizeof size;
        if ((size_t)(end - bytes) < size)
            return none(x);
        const int status = ON_PART(unpack, bytes, size, &s->parts[i]);
        if (status > WARNING)
            return part_failed(x, i, __func__, status);
        bytes += size;
    }
    return OK;
}

Status instance_deserialize(Instance *x, const uint8_t *bytes, size_t size, void **state) {
    REQUIRE_ALIVE
    const size_t head = sizeof TOKEN + sizeof(Own);
    if (size < head || memcmp(bytes, TOKEN, sizeof TOKEN) != 0)
        return none(x);
    State *s = calloc(1, sizeof *s);
    if (!s)
        return report(x, ERROR, "there is no memory left for the state");
    *state = s;
    memcpy(&s->own, bytes + sizeof TOKEN, sizeof s->own);
    const Status status = unpack_parts(x, bytes + head, bytes + size, s);
    if (status != OK)
        instance_forget(x, state);
    return status;
}
