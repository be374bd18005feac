/* Snapshots of an instance, which the tool keeps, as they are or as bytes. */
#include <string.h>

#include "heap.h"
#include "instance.h"

struct Saved {
    Saved *next;
    Snapshot state;
};

/* What stands before a snapshot among the bytes. */
typedef struct {
    char token[START_TOKEN_SIZE];
    uint8_t model_exchange;
    uint8_t hash[8];
} Label;

/* Where the list points to a snapshot; NULL when it is none of this instance. */
static Saved **find(Instance *i, const void *snapshot) {
    for (Saved **place = &i->saved; *place; place = &(*place)->next)
        if (*place == snapshot)
            return place;
    instance_report(i, ERROR, "logStatusError", "there is no such state of this instance");
    return NULL;
}

static Status add(Instance *i, void **snapshot) {
    Saved *saved = heap_get(sizeof *saved);
    if (!saved)
        return instance_report(i, ERROR, "logStatusError", "no memory left to save the state");
    saved->next = i->saved;
    *snapshot = i->saved = saved;
    return OK;
}

Status instance_save(Instance *i, void **snapshot) {
    if (*snapshot ? !find(i, *snapshot) : add(i, snapshot) != OK)
        return ERROR;
    memcpy(&((Saved *)*snapshot)->state, &i->now, sizeof i->now);
    return OK;
}

Status instance_restore(Instance *i, const void *snapshot) {
    if (!find(i, snapshot))
        return ERROR;
    memcpy(&i->now, &((const Saved *)snapshot)->state, sizeof i->now);
    return OK;
}

Status instance_forget(Instance *i, void **snapshot) {
    Saved **place = *snapshot ? find(i, *snapshot) : NULL;
    if (*snapshot && !place)
        return ERROR;
    if (place) {
        *place = (*place)->next;
        heap_free(*snapshot);
    }
    *snapshot = NULL;
    return OK;
}

void instance_forget_all(Instance *i) {
    while (i->saved) {
        void *snapshot = i->saved;
        instance_forget(i, &snapshot);
    }
}

/* FNV-1a (Fowler, Noll, Vo). */
static uint64_t hash_of(const uint8_t *bytes, size_t size) {
    uint64_t hash = 0xCBF29CE484222325u;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ bytes[k]) * 0x100000001B3u;
    return hash;
}

static Label label_of(const Instance *i, const uint8_t *state) {
    const uint64_t hash = hash_of(state, sizeof(Snapshot));
    Label label = {.model_exchange = i->model_exchange};
    memcpy(label.token, START.token, sizeof label.token);
    memcpy(label.hash, &hash, sizeof hash);
    return label;
}

Status instance_serialized_size(Instance *i, const void *snapshot, size_t *size) {
    if (!find(i, snapshot))
        return ERROR;
    *size = sizeof(Label) + sizeof(Snapshot);
    return OK;
}

Status instance_serialize(Instance *i, const void *snapshot, uint8_t bytes[], size_t size) {
    if (!find(i, snapshot))
        return ERROR;
    if (size < sizeof(Label) + sizeof(Snapshot))
        return instance_report(i, ERROR, "logStatusError", "the state needs %zu bytes, got %zu",
                               sizeof(Label) + sizeof(Snapshot), size);
    memcpy(bytes + sizeof(Label), &((const Saved *)snapshot)->state, sizeof(Snapshot));
    const Label label = label_of(i, bytes + sizeof(Label));
    memcpy(bytes, &label, sizeof label);
    return OK;
}

Status instance_deserialize(Instance *i, const uint8_t bytes[], size_t size, void **snapshot) {
    bool fits = size == sizeof(Label) + sizeof(Snapshot);
    if (fits) {
        const Label label = label_of(i, bytes + sizeof(Label));
        fits = memcmp(bytes, &label, sizeof label) == 0;
    }
    if (!fits)
        return instance_report(i, ERROR, "logStatusError",
                               "these %zu bytes are not a state of this build and interface", size);
    if (add(i, snapshot) != OK)
        return ERROR;
    memcpy(&((Saved *)*snapshot)->state, bytes + sizeof(Label), sizeof(Snapshot));
    return OK;
}
