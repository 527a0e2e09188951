/* SPDX-License-Identifier: Apache-2.0
 * Finds and loads ONNX Runtime, and opens and runs sessions. No other file uses ONNX Runtime.
 *
 * Sessions are single-threaded: libbn runs the tiles of an image in parallel on its own threads, so
 * no idle threads spin in the host's process, and the thread count does not change results. Tensors
 * are in main memory; ONNX Runtime copies them to a GPU and back. It has one reference-counted
 * environment per process, to which every network holds a reference. Once the environment exists,
 * the library is never unloaded, because it may have left threads or exit handlers behind. */
#define _POSIX_C_SOURCE 200809L
#include "neural/onnxruntime.h"
#include "base/memory.h"
#include "neural/files.h"
#include "neural/onnxruntime_api.h"
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
#elif defined(__unix__) || defined(__APPLE__)
#include <dlfcn.h>
#include <unistd.h>
#define BN_HAVE_DLFCN
#if defined(__linux__)
#include <sys/auxv.h>
#endif
#endif

/* ---- Libraries */

typedef struct library {
    void *handle;
    int was_loaded; /* before this call, by the host */
} library;

#if defined(_WIN32)

typedef wchar_t path_char;
#define NATIVE(text) L##text
#define library_load(name) (void *)LoadLibraryW(name)
#define library_unload(handle) FreeLibrary((HMODULE)(handle))
#define library_is_loaded(name) (GetModuleHandleW(name) != NULL)
#define get_variable(name) _wgetenv(NATIVE(name))
#define set_variable(name, value) _putenv_s(name, value)
#define has_more_rights_than_user() 0

static bn_ort_get_api_base library_entry(void *handle) {
    return (bn_ort_get_api_base)(void (*)(void))GetProcAddress((HMODULE)handle, "OrtGetApiBase");
}

#elif defined(BN_HAVE_DLFCN)

typedef char path_char;
#define NATIVE(text) text
#define library_load(name) dlopen(name, RTLD_NOW | RTLD_LOCAL)
#define library_unload(handle) dlclose(handle)
#define get_variable(name) getenv(name)
#define set_variable(name, value) setenv(name, value, 0)

static int library_is_loaded(const char *name) {
#if defined(RTLD_NOLOAD)
    void *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
    if (handle != NULL) dlclose(handle);
    return handle != NULL;
#else
    (void)name;
    return 0;
#endif
}

static bn_ort_get_api_base library_entry(void *handle) {
    /* POSIX allows conversion between object and function pointers; C does not. */
    void *symbol = dlsym(handle, "OrtGetApiBase");
    bn_ort_get_api_base entry = NULL;
    memcpy(&entry, &symbol, sizeof entry);
    return entry;
}

/* For example a set-user-ID program, whose user must not choose the code it runs. */
static int has_more_rights_than_user(void) {
#if defined(__linux__)
    if (getauxval(AT_SECURE) != 0) return 1; /* covers file capabilities too */
#endif
    return getuid() != geteuid() || getgid() != getegid();
}

#endif

#if defined(_WIN32) || defined(BN_HAVE_DLFCN)

#if defined(_WIN32)
static const path_char *const library_names[] = {L"onnxruntime.dll"};
#elif defined(__APPLE__)
static const path_char *const library_names[] = {"libonnxruntime.1.dylib", "libonnxruntime.dylib"};
#else
static const path_char *const library_names[] = {"libonnxruntime.so.1", "libonnxruntime.so"};
#endif

static int load_named(const path_char *name, library *found) {
    found->was_loaded = library_is_loaded(name);
    /* Version 1.29 and later send telemetry before any call can disable it. A variable that is
     * already set is left unchanged; see the note on threads in neural.h. */
    if (!found->was_loaded && getenv("ORT_DISABLE_TELEMETRY") == NULL) {
        set_variable("ORT_DISABLE_TELEMETRY", "1");
    }
    found->handle = library_load(name);
    return found->handle != NULL;
}

static int load_anywhere(library *found) {
#if defined(BN_HAVE_DLFCN)
    /* Look in the program itself and the libraries it is linked with. */
    found->was_loaded = 1;
    found->handle = library_load(NULL);
    if (found->handle != NULL && library_entry(found->handle) != NULL) return 1;
    if (found->handle != NULL) library_unload(found->handle);
#endif
    for (size_t i = 0; i < sizeof library_names / sizeof *library_names; ++i) {
        if (library_is_loaded(library_names[i]) && load_named(library_names[i], found)) return 1;
    }
    for (size_t i = 0; i < sizeof library_names / sizeof *library_names; ++i) {
        if (load_named(library_names[i], found)) return 1;
    }
    return 0;
}

static int load_library(const char *given, library *found) {
    const path_char *path = NULL;
#if defined(_WIN32)
    if (given != NULL) {
        wchar_t *wide = bn_file_wide(given);
        const int loaded = wide != NULL && load_named(wide, found);
        bn_free(wide);
        return loaded;
    }
#else
    path = given;
#endif
    if (path == NULL && !has_more_rights_than_user()) path = get_variable("BN_ONNXRUNTIME");
    if (path != NULL && *path != 0) return load_named(path, found);
    return load_anywhere(found);
}

#else

#define library_unload(handle) (void)(handle)

#endif

/* ---- Sessions */

/* ONNX Runtime allows concurrent runs of a session; everything else is only read. */
struct bn_runtime {
    const bn_ort_api *api; /* belongs to the library */
    bn_ort_env *env;
    bn_ort_session *session;
    bn_ort_memory_info *memory;
};

/* Whether a call succeeded; releases its status. */
static int done(const bn_ort_api *api, bn_ort_status *status) {
    if (status == NULL) return 1;
    api->release_status(status);
    return 0;
}

/* Converts the status of a session that could not be created to a result, and releases it. A CPU can
 * run every valid model; a GPU may be missing, or lack an operator. */
static bn_result blame(const bn_ort_api *api, bn_ort_status *status, bn_provider provider) {
    const int code = api->get_error_code(status);
    api->release_status(status);
    return provider == BN_PROVIDER_CPU || code == BN_ORT_INVALID_PROTOBUF ||
                   code == BN_ORT_NOT_IMPLEMENTED || code == BN_ORT_INVALID_GRAPH
               ? BN_ERROR_BAD_DATA
               : BN_ERROR_RUNTIME;
}

/* The function table of a library; NULL if it is too old or not ONNX Runtime. Checks the version
 * first, because a library that is asked for an unknown version prints a message. */
static const bn_ort_api *get_table(bn_ort_get_api_base entry) {
    const bn_ort_api_base *base = entry != NULL ? entry() : NULL;
    const char *version = base != NULL ? base->get_version_string() : NULL;
    if (version == NULL) return NULL;
    char *end;
    const unsigned long major = strtoul(version, &end, 10);
    if (end == version || *end != '.' || major < 1) return NULL;
    const char *text = end + 1;
    unsigned long minor = strtoul(text, &end, 10);
    if (end == text) return NULL;
    if (major > 1 || minor > BN_ORT_NEWEST) minor = BN_ORT_NEWEST;
    return minor < BN_ORT_OLDEST ? NULL : base->get_api((uint32_t)minor);
}

/* Adds the CUDA provider, which must run the whole model: otherwise operators could silently fall
 * back to the CPU. By default, it tries every algorithm for each new input size, which takes longer
 * than inference itself, and lets recent GPUs round inputs to ten bits (TF32), so windows would not
 * match. Older versions lack the option to disable TF32. */
static int add_cuda(const bn_ort_api *api, bn_ort_session_options *options) {
    static const char *const keys[] = {"cudnn_conv_algo_search", "use_tf32"};
    static const char *const values[] = {"HEURISTIC", "0"};
    bn_ort_cuda_options *cuda = NULL;
    if (!done(api, api->create_cuda_provider_options(&cuda))) return 0;
    const int good =
        (done(api, api->update_cuda_provider_options(cuda, keys, values, 2)) ||
         done(api, api->update_cuda_provider_options(cuda, keys, values, 1))) &&
        done(api, api->session_options_append_execution_provider_cuda_v2(options, cuda)) &&
        done(api, api->add_session_config_entry(options, "session.disable_cpu_ep_fallback", "1"));
    api->release_cuda_provider_options(cuda);
    return good;
}

static bn_result open_session(bn_runtime *r, bn_provider provider, const void *model, size_t size) {
    static const char *const settings[][2] = {
        {"session.intra_op.allow_spinning", "0"},
        {"session.inter_op.allow_spinning", "0"},
        {"session.load_model_format", "ONNX"},
    };
    const bn_ort_api *api = r->api;
    bn_ort_session_options *options = NULL;
    if (!done(api, api->create_session_options(&options))) return BN_ERROR_RUNTIME;
    int good = done(api, api->set_session_log_severity_level(options, BN_ORT_LOG_FATAL)) &&
               done(api, api->set_session_graph_optimization_level(options, BN_ORT_OPTIMISE_ALL)) &&
               done(api, api->set_intra_op_num_threads(options, 1)) &&
               done(api, api->set_inter_op_num_threads(options, 1));
    for (size_t i = 0; i < sizeof settings / sizeof *settings && good; ++i) {
        good = done(api, api->add_session_config_entry(options, settings[i][0], settings[i][1]));
    }
    if (good && provider == BN_PROVIDER_CUDA) good = add_cuda(api, options);
    bn_result result = good ? BN_SUCCESS : BN_ERROR_RUNTIME;
    if (good) {
        bn_ort_status *status =
            api->create_session_from_array(r->env, model, size, options, &r->session);
        /* Versions 1.19 to 1.21 give the nodes that this optimisation makes of nameless nodes one name, and then
         * reject the model. */
        if (status != NULL && api->get_error_code(status) == BN_ORT_FAIL &&
            done(api,
                 api->add_session_config_entry(options, "optimization.disable_specified_optimizers",
                                               "GatherSliceToSplitFusion"))) {
            api->release_status(status);
            status = api->create_session_from_array(r->env, model, size, options, &r->session);
        }
        if (status != NULL) result = blame(api, status, provider);
    }
    api->release_session_options(options);
    return result;
}

bn_result bn_runtime_open(const char *library_path, bn_provider provider, const void *model,
                          size_t size, bn_runtime **runtime) {
#if defined(_WIN32) || defined(BN_HAVE_DLFCN)
    library found = {NULL, 0};
    if (!load_library(library_path, &found)) return BN_ERROR_RUNTIME;
    const bn_ort_api *api = get_table(library_entry(found.handle));
#else
    library found = {NULL, 0};
    const bn_ort_api *api = NULL;
    (void)library_path;
    (void)get_table;
    if (found.handle == NULL) return BN_ERROR_UNSUPPORTED;
#endif
    bn_runtime *r = api != NULL ? bn_allocate_zero(1, sizeof *r) : NULL;
    if (r == NULL) {
        library_unload(found.handle);
        return api != NULL ? BN_ERROR_OUT_OF_MEMORY : BN_ERROR_RUNTIME;
    }
    bn_result result = BN_ERROR_RUNTIME;
    r->api = api;
    /* If the host loaded the library itself, telemetry is the host's decision. */
    if (done(api, api->create_env(BN_ORT_LOG_FATAL, "bn", &r->env)) &&
        (found.was_loaded || done(api, api->disable_telemetry_events(r->env))) &&
        done(api, api->create_cpu_memory_info(BN_ORT_ARENA_ALLOCATOR, BN_ORT_MEMORY_DEFAULT,
                                              &r->memory))) {
        result = open_session(r, provider, model, size);
    }
    if (result == BN_SUCCESS) {
        *runtime = r;
    } else {
        bn_runtime_close(r);
    }
    return result;
}

void bn_runtime_close(bn_runtime *r) {
    if (r == NULL) return;
    if (r->session != NULL) r->api->release_session(r->session);
    if (r->memory != NULL) r->api->release_memory_info(r->memory);
    if (r->env != NULL) r->api->release_env(r->env);
    bn_free(r);
}

/* Copies a string that the runtime allocated, and frees it; NULL becomes an empty string. */
static bn_result take_text(const bn_runtime *r, bn_ort_allocator *allocator, char *from,
                           char to[BN_RUNTIME_TEXT_SIZE]) {
    const size_t length = from != NULL ? strlen(from) : 0;
    const int fits = length < BN_RUNTIME_TEXT_SIZE;
    if (fits && length != 0) memcpy(to, from, length);
    to[fits ? length : 0] = 0;
    if (from != NULL && !done(r->api, r->api->allocator_free(allocator, from))) {
        return BN_ERROR_RUNTIME;
    }
    return fits ? BN_SUCCESS : BN_ERROR_BAD_DATA;
}

bn_result bn_runtime_metadata(const bn_runtime *r, const char *key,
                              char text[BN_RUNTIME_TEXT_SIZE]) {
    const bn_ort_api *api = r->api;
    bn_ort_allocator *allocator = NULL;
    bn_ort_model_metadata *metadata = NULL;
    char *found = NULL;
    if (!done(api, api->get_allocator_with_default_options(&allocator)) ||
        !done(api, api->session_get_model_metadata(r->session, &metadata))) {
        return BN_ERROR_RUNTIME;
    }
    const int good =
        done(api, api->model_metadata_lookup_custom_metadata_map(metadata, allocator, key, &found));
    api->release_model_metadata(metadata);
    return good ? take_text(r, allocator, found, text) : BN_ERROR_RUNTIME;
}

/* The number of channels C of a float tensor (1, C, h, w). */
static bn_result read_shape(const bn_ort_api *api, const bn_ort_type_info *type,
                            uint32_t *channels) {
    const bn_ort_tensor_info *tensor = NULL; /* belongs to the type */
    int64_t extents[4] = {0};
    size_t axes = 0;
    int element = 0;
    if (!done(api, api->cast_type_info_to_tensor_info(type, &tensor))) return BN_ERROR_RUNTIME;
    if (tensor == NULL) return BN_ERROR_BAD_DATA;
    if (!done(api, api->get_tensor_element_type(tensor, &element)) ||
        !done(api, api->get_dimensions_count(tensor, &axes))) {
        return BN_ERROR_RUNTIME;
    }
    if (element != BN_ORT_FLOAT || axes != 4) return BN_ERROR_BAD_DATA;
    if (!done(api, api->get_dimensions(tensor, extents, axes))) return BN_ERROR_RUNTIME;
    if (extents[0] != 1 || extents[1] < 1 || extents[1] > INT32_MAX) return BN_ERROR_BAD_DATA;
    *channels = (uint32_t)extents[1];
    return BN_SUCCESS;
}

bn_result bn_runtime_value(const bn_runtime *r, bn_runtime_side side,
                           char name[BN_RUNTIME_TEXT_SIZE], uint32_t *channels) {
    const bn_ort_api *api = r->api;
    const int in = side == BN_RUNTIME_INPUT;
    bn_ort_allocator *allocator = NULL;
    bn_ort_type_info *type = NULL;
    size_t count = 0;
    char *found = NULL;
    if (!done(api, (in ? api->session_get_input_count : api->session_get_output_count)(r->session,
                                                                                       &count))) {
        return BN_ERROR_RUNTIME;
    }
    if (count != 1) return BN_ERROR_BAD_DATA;
    if (!done(api, api->get_allocator_with_default_options(&allocator)) ||
        !done(api, (in ? api->session_get_input_name
                       : api->session_get_output_name)(r->session, 0, allocator, &found))) {
        return BN_ERROR_RUNTIME;
    }
    bn_result result = take_text(r, allocator, found, name);
    if (result != BN_SUCCESS) return result;
    if (!done(api, (in ? api->session_get_input_type_info
                       : api->session_get_output_type_info)(r->session, 0, &type))) {
        return BN_ERROR_RUNTIME;
    }
    result = read_shape(api, type, channels);
    api->release_type_info(type);
    return result;
}

/* Wraps a tensor's values, without copying them; NULL on failure. */
static bn_ort_value *make_value(const bn_runtime *r, const bn_tensor *t) {
    const int64_t shape[4] = {1, t->channels, t->height, t->width};
    const size_t count = (size_t)t->channels * t->height * t->width;
    bn_ort_value *value = NULL;
    const int good = done(r->api, r->api->create_tensor_with_data_as_ort_value(
                                      r->memory, t->values, count * sizeof *t->values, shape, 4,
                                      BN_ORT_FLOAT, &value));
    return good ? value : NULL;
}

bn_result bn_runtime_run(const bn_runtime *r, const bn_tensor *input, const char *output_name,
                         const bn_tensor *output) {
    const char *const input_names[] = {"noise"}, *const output_names[] = {output_name};
    bn_ort_value *in = make_value(r, input);
    bn_ort_value *out = in != NULL ? make_value(r, output) : NULL;
    bn_result result = BN_ERROR_RUNTIME;
    if (out != NULL) {
        const bn_ort_value *const inputs[] = {in};
        bn_ort_value *outputs[] = {out};
        if (done(r->api,
                 r->api->run(r->session, NULL, input_names, inputs, 1, output_names, 1, outputs))) {
            result = BN_SUCCESS;
        }
    }
    if (out != NULL) r->api->release_value(out);
    if (in != NULL) r->api->release_value(in);
    return result;
}
