/* SPDX-License-Identifier: Apache-2.0
 * A fake ONNX Runtime, which tests load in place of the real library. It computes a known function and
 * counts its objects. Tests can make calls fail and features disappear. */
#define _GNU_SOURCE
#include "fake_onnxruntime.h"
#include "../../libbn/src/neural/onnxruntime_api.h"
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define EXPORT __attribute__((visibility("default")))

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static fake_state state;

EXPORT fake_state *fake_get_state(void);
fake_state *fake_get_state(void) {
    return &state;
}

struct bn_ort_value {
    float *values;
    int64_t shape[4];
};

struct bn_ort_session {
    fake_model model;
    int cuda;
};

struct bn_ort_model_metadata {
    const bn_ort_session *session;
};

struct bn_ort_type_info {
    int64_t channels;
};

struct bn_ort_session_options {
    int cuda, precise, stays, unfused;
};

struct bn_ort_cuda_options {
    int precise;
};

/* Allocates every object separately, so that sanitizers detect leaks. */
static void *make(size_t size) {
    pthread_mutex_lock(&mutex);
    ++state.living;
    pthread_mutex_unlock(&mutex);
    return calloc(1, size);
}

static void forget(void *object) {
    pthread_mutex_lock(&mutex);
    --state.living;
    pthread_mutex_unlock(&mutex);
    free(object);
}

/* Counts a call that can fail. Returns an error status if this is the call that should fail. */
static bn_ort_status *called(void) {
    pthread_mutex_lock(&mutex);
    const int fails = ++state.calls == state.fail_at;
    pthread_mutex_unlock(&mutex);
    return fails ? make(1) : NULL;
}

static bn_ort_status *create(void **object, size_t size) {
    bn_ort_status *status = called();
    if (status == NULL) *object = make(size);
    return status;
}

static int get_error_code(const bn_ort_status *status) {
    return state.error_code;
}

static bn_ort_status *create_env(int level, const char *name, bn_ort_env **env) {
    state.log_level = level;
    return create((void **)env, 1);
}

static bn_ort_status *disable_telemetry(const bn_ort_env *env) {
    ++state.telemetry_disabled;
    return called();
}

static bn_ort_status *create_options(bn_ort_session_options **options) {
    return create((void **)options, sizeof **options);
}

static bn_ort_status *set_number(bn_ort_session_options *options, int value) {
    return called();
}

static bn_ort_status *add_entry(bn_ort_session_options *options, const char *key,
                                const char *value) {
    if (strcmp(key, "session.intra_op.allow_spinning") == 0) state.spinning = *value != '0';
    if (strcmp(key, "session.disable_cpu_ep_fallback") == 0) options->stays = *value == '1';
    if (strcmp(key, "optimization.disable_specified_optimizers") == 0) options->unfused = 1;
    return called();
}

static bn_ort_status *create_cuda(bn_ort_cuda_options **cuda) {
    return state.lacks_cuda ? make(1) : create((void **)cuda, sizeof **cuda);
}

static bn_ort_status *update_cuda(bn_ort_cuda_options *cuda, const char *const *keys,
                                  const char *const *values, size_t count) {
    cuda->precise = state.lacks_tf32;
    for (size_t i = 0; i < count; ++i) {
        const int tf32 = strcmp(keys[i], "use_tf32") == 0;
        if (tf32 && state.lacks_tf32) return make(1);
        if (tf32) cuda->precise = strcmp(values[i], "0") == 0;
    }
    return called();
}

static bn_ort_status *append_cuda(bn_ort_session_options *options,
                                  const bn_ort_cuda_options *cuda) {
    options->cuda = 1;
    options->precise = cuda->precise;
    return called();
}

/* Copies a string, which the caller must free. The copy of NULL is NULL. */
static bn_ort_status *give_text(const char *text, char **copy) {
    bn_ort_status *status = called();
    *copy = NULL;
    if (status != NULL || text == NULL) return status;
    *copy = make(strlen(text) + 1);
    memcpy(*copy, text, strlen(text) + 1);
    return NULL;
}

static bn_ort_status *get_metadata(const bn_ort_session *session,
                                   bn_ort_model_metadata **metadata) {
    bn_ort_status *status = create((void **)metadata, sizeof **metadata);
    if (status == NULL) (*metadata)->session = session;
    return status;
}

static bn_ort_status *look_up_metadata(const bn_ort_model_metadata *metadata,
                                       bn_ort_allocator *allocator, const char *key, char **value) {
    const fake_model *model = &metadata->session->model;
    const struct {
        const char *key;
        int value;
    } entries[] = {{"bn.version", 1},
                   {"bn.receptive_radius", model->radius},
                   {"bn.align", model->align},
                   {model->spacing != 0 ? "bn.sparse_spacing" : "", model->spacing}};
    char number[16];
    for (int i = 0; i < 4; ++i) {
        if (strcmp(key, entries[i].key) != 0) continue;
        snprintf(number, sizeof number, "%d", entries[i].value);
        return give_text(number, value);
    }
    return give_text(NULL, value);
}

static bn_ort_status *get_allocator(bn_ort_allocator **allocator) {
    *allocator = NULL;
    return called();
}

static bn_ort_status *give_back(bn_ort_allocator *allocator, void *memory) {
    forget(memory);
    return called();
}

static bn_ort_status *count_values(const bn_ort_session *session, size_t *count) {
    *count = 1;
    return called();
}

#define VALUE(side, called_, channels_)                                                            \
    static bn_ort_status *side##_name(const bn_ort_session *session, size_t index,                 \
                                      bn_ort_allocator *allocator, char **name) {                  \
        return give_text(called_, name);                                                           \
    }                                                                                              \
    static bn_ort_status *side##_type(const bn_ort_session *session, size_t index,                 \
                                      bn_ort_type_info **type) {                                   \
        bn_ort_status *status = create((void **)type, sizeof **type);                              \
        if (status == NULL) (*type)->channels = channels_;                                         \
        return status;                                                                             \
    }
VALUE(input, "noise", 1)
VALUE(output, "mask", session->model.channels)

static bn_ort_status *as_tensor(const bn_ort_type_info *type, const bn_ort_tensor_info **tensor) {
    *tensor = (const bn_ort_tensor_info *)(const void *)type;
    return called();
}

static bn_ort_status *get_element(const bn_ort_tensor_info *tensor, int *element) {
    *element = BN_ORT_FLOAT;
    return called();
}

static bn_ort_status *count_axes(const bn_ort_tensor_info *tensor, size_t *count) {
    *count = 4;
    return called();
}

static bn_ort_status *get_extents(const bn_ort_tensor_info *tensor, int64_t *extents,
                                  size_t count) {
    const bn_ort_type_info *type = (const bn_ort_type_info *)(const void *)tensor;
    for (size_t i = 2; i < count; ++i) extents[i] = -1;
    extents[0] = 1;
    extents[1] = type->channels;
    return called();
}

static bn_ort_status *create_session(const bn_ort_env *env, const void *model, size_t size,
                                     const bn_ort_session_options *options,
                                     bn_ort_session **session) {
    if (options->cuda && state.lacks_gpu) return make(1);
    if (state.needs_names && !options->unfused) return make(1);
    bn_ort_status *status = create((void **)session, sizeof **session);
    if (status == NULL) {
        (*session)->cuda = options->cuda;
        state.fallbacks += options->cuda && !options->stays;
        state.rough += options->cuda && !options->precise;
        if (size != sizeof(*session)->model) abort();
        memcpy(&(*session)->model, model, size);
    }
    return status;
}

static bn_ort_status *create_memory(int allocator, int type, bn_ort_memory_info **memory) {
    return create((void **)memory, 1);
}

static bn_ort_status *create_tensor(const bn_ort_memory_info *memory, void *data, size_t data_size,
                                    const int64_t *shape, size_t shape_count, int element,
                                    bn_ort_value **value) {
    size_t size = sizeof(float);
    for (size_t i = 0; i < shape_count; ++i) size *= (size_t)shape[i];
    if (shape_count != 4 || element != BN_ORT_FLOAT || size != data_size) return make(1);
    bn_ort_status *status = create((void **)value, sizeof **value);
    if (status == NULL) {
        (*value)->values = data;
        memcpy((*value)->shape, shape, sizeof(*value)->shape);
    }
    return status;
}

/* If the test requests it, waits up to ten seconds for two threads to be in this function at once. */
static void meet(void) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += 10;
    pthread_mutex_lock(&mutex);
    if (++state.running > state.most_running) state.most_running = state.running;
    pthread_cond_broadcast(&changed);
    while (state.meet && state.most_running < 2) {
        if (pthread_cond_timedwait(&changed, &mutex, &until) != 0) break;
    }
    pthread_mutex_unlock(&mutex);
}

static bn_ort_status *run(bn_ort_session *session, const bn_ort_run_options *options,
                          const char *const *input_names, const bn_ort_value *const *inputs,
                          size_t input_count, const char *const *output_names, size_t output_count,
                          bn_ort_value **outputs) {
    const int64_t r = session->model.radius;
    const bn_ort_value *in = inputs[0];
    bn_ort_value *out = outputs[0];
    const int64_t channels = out->shape[1], height = out->shape[2], width = out->shape[3];
    bn_ort_status *status = called();
    if (status != NULL) return status;
    if (input_count != 1 || output_count != 1 || strcmp(input_names[0], "noise") != 0 ||
        strcmp(output_names[0], "mask") != 0 || in->shape[1] != 1 ||
        in->shape[2] != height + 2 * r || in->shape[3] != width + 2 * r ||
        height % session->model.align != 0 || width % session->model.align != 0) {
        return make(1);
    }
    meet();
    for (int64_t c = 0; c < channels; ++c) {
        for (int64_t y = 0; y < height; ++y) {
            for (int64_t x = 0; x < width; ++x) {
                const float *corner = in->values + y * in->shape[3] + x;
                out->values[(c * height + y) * width + x] =
                    fake_network((uint32_t)c, corner[0], corner[r * in->shape[3] + r],
                                 corner[2 * r * in->shape[3] + 2 * r]);
            }
        }
    }
    pthread_mutex_lock(&mutex);
    if (state.spoil_from != 0 && state.calls >= state.spoil_from) {
        out->values[channels * height * width - 1] = state.spoil_with;
    }
    --state.running;
    ++state.runs;
    state.cuda_runs += session->cuda;
    pthread_mutex_unlock(&mutex);
    return NULL;
}

#define RELEASE(name, type)                                                                        \
    static void name(type *object) {                                                               \
        forget(object);                                                                            \
    }
RELEASE(release_env, bn_ort_env)
RELEASE(release_status, bn_ort_status)
RELEASE(release_memory, bn_ort_memory_info)
RELEASE(release_session, bn_ort_session)
RELEASE(release_value, bn_ort_value)
RELEASE(release_options, bn_ort_session_options)
RELEASE(release_cuda, bn_ort_cuda_options)
RELEASE(release_type, bn_ort_type_info)
RELEASE(release_metadata, bn_ort_model_metadata)

static const bn_ort_api table = {
    .get_error_code = get_error_code,
    .create_env = create_env,
    .disable_telemetry_events = disable_telemetry,
    .create_session_from_array = create_session,
    .run = run,
    .create_session_options = create_options,
    .set_session_log_severity_level = set_number,
    .set_session_graph_optimization_level = set_number,
    .set_intra_op_num_threads = set_number,
    .set_inter_op_num_threads = set_number,
    .create_tensor_with_data_as_ort_value = create_tensor,
    .create_cpu_memory_info = create_memory,
    .session_get_input_count = count_values,
    .session_get_output_count = count_values,
    .session_get_input_type_info = input_type,
    .session_get_output_type_info = output_type,
    .session_get_input_name = input_name,
    .session_get_output_name = output_name,
    .cast_type_info_to_tensor_info = as_tensor,
    .get_tensor_element_type = get_element,
    .get_dimensions_count = count_axes,
    .get_dimensions = get_extents,
    .allocator_free = give_back,
    .get_allocator_with_default_options = get_allocator,
    .release_type_info = release_type,
    .session_get_model_metadata = get_metadata,
    .model_metadata_lookup_custom_metadata_map = look_up_metadata,
    .release_model_metadata = release_metadata,
    .release_env = release_env,
    .release_status = release_status,
    .release_memory_info = release_memory,
    .release_session = release_session,
    .release_value = release_value,
    .release_session_options = release_options,
    .add_session_config_entry = add_entry,
    .session_options_append_execution_provider_cuda_v2 = append_cuda,
    .create_cuda_provider_options = create_cuda,
    .update_cuda_provider_options = update_cuda,
    .release_cuda_provider_options = release_cuda,
};

static const bn_ort_api *get_api(uint32_t version) {
    state.asked_version = version;
    return state.lacks_table ? NULL : &table;
}

static const char *get_version_string(void) {
    return state.version != NULL ? state.version : "1.21.0";
}

EXPORT const bn_ort_api_base *OrtGetApiBase(void);
const bn_ort_api_base *OrtGetApiBase(void) {
    static const bn_ort_api_base base = {get_api, get_version_string};
    return state.lacks_base ? NULL : &base;
}
