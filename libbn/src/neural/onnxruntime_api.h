/* SPDX-License-Identifier: Apache-2.0
 * Declares the part of ONNX Runtime's C API that libbn calls, so that libbn builds without its
 * headers.
 *
 * The API is a table of function pointers that only grows at its end, so an entry has the same index
 * in every version. The gaps are entries that libbn does not call. */
#ifndef BN_ONNXRUNTIME_API_H
#define BN_ONNXRUNTIME_API_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define BN_ORT_CALL __stdcall
#else
#define BN_ORT_CALL
#endif

typedef struct bn_ort_status bn_ort_status;
typedef struct bn_ort_env bn_ort_env;
typedef struct bn_ort_session bn_ort_session;
typedef struct bn_ort_session_options bn_ort_session_options;
typedef struct bn_ort_run_options bn_ort_run_options;
typedef struct bn_ort_memory_info bn_ort_memory_info;
typedef struct bn_ort_value bn_ort_value;
typedef struct bn_ort_cuda_options bn_ort_cuda_options;
typedef struct bn_ort_allocator bn_ort_allocator;
typedef struct bn_ort_type_info bn_ort_type_info;
typedef struct bn_ort_tensor_info bn_ort_tensor_info;
typedef struct bn_ort_model_metadata bn_ort_model_metadata;
typedef void(BN_ORT_CALL *bn_ort_gap)(void);

enum {
    BN_ORT_OLDEST = 17, /* table versions to ask for */
    BN_ORT_NEWEST = 21,
    BN_ORT_LOG_FATAL = 4,
    BN_ORT_OPTIMISE_ALL = 99,
    BN_ORT_FLOAT = 1,
    BN_ORT_ARENA_ALLOCATOR = 1,
    BN_ORT_MEMORY_DEFAULT = 0,
    BN_ORT_FAIL = 1,             /* a status code without a more specific meaning */
    BN_ORT_INVALID_PROTOBUF = 7, /* status codes that mean a bad model */
    BN_ORT_NOT_IMPLEMENTED = 9,
    BN_ORT_INVALID_GRAPH = 10
};

/* Functions that can fail return NULL, or a status to release; their outputs then stay NULL. */
typedef struct bn_ort_api {
    bn_ort_gap gap_0[1];
    int(BN_ORT_CALL *get_error_code)(const bn_ort_status *status);
    bn_ort_gap gap_2[1];
    bn_ort_status *(BN_ORT_CALL *create_env)(int log_level, const char *name, bn_ort_env **env);
    bn_ort_gap gap_4[2];
    bn_ort_status *(BN_ORT_CALL *disable_telemetry_events)(const bn_ort_env *env);
    bn_ort_gap gap_7[1];
    bn_ort_status *(BN_ORT_CALL *create_session_from_array)(const bn_ort_env *env,
                                                            const void *model, size_t size,
                                                            const bn_ort_session_options *options,
                                                            bn_ort_session **session);
    bn_ort_status *(BN_ORT_CALL *run)(bn_ort_session *session, const bn_ort_run_options *options,
                                      const char *const *input_names,
                                      const bn_ort_value *const *inputs, size_t input_count,
                                      const char *const *output_names, size_t output_count,
                                      bn_ort_value **outputs);
    bn_ort_status *(BN_ORT_CALL *create_session_options)(bn_ort_session_options **options);
    bn_ort_gap gap_11[11];
    bn_ort_status *(BN_ORT_CALL *set_session_log_severity_level)(bn_ort_session_options *options,
                                                                 int level);
    bn_ort_status *(BN_ORT_CALL *set_session_graph_optimization_level)(
        bn_ort_session_options *options, int level);
    bn_ort_status *(BN_ORT_CALL *set_intra_op_num_threads)(bn_ort_session_options *options,
                                                           int threads);
    bn_ort_status *(BN_ORT_CALL *set_inter_op_num_threads)(bn_ort_session_options *options,
                                                           int threads);
    bn_ort_gap gap_26[4];
    bn_ort_status *(BN_ORT_CALL *session_get_input_count)(const bn_ort_session *session,
                                                          size_t *count);
    bn_ort_status *(BN_ORT_CALL *session_get_output_count)(const bn_ort_session *session,
                                                           size_t *count);
    bn_ort_gap gap_32[1];
    bn_ort_status *(BN_ORT_CALL *session_get_input_type_info)(const bn_ort_session *session,
                                                              size_t index,
                                                              bn_ort_type_info **type);
    bn_ort_status *(BN_ORT_CALL *session_get_output_type_info)(const bn_ort_session *session,
                                                               size_t index,
                                                               bn_ort_type_info **type);
    bn_ort_gap gap_35[1];
    bn_ort_status *(BN_ORT_CALL *session_get_input_name)(const bn_ort_session *session,
                                                         size_t index, bn_ort_allocator *allocator,
                                                         char **name);
    bn_ort_status *(BN_ORT_CALL *session_get_output_name)(const bn_ort_session *session,
                                                          size_t index, bn_ort_allocator *allocator,
                                                          char **name);
    bn_ort_gap gap_38[11];
    bn_ort_status *(BN_ORT_CALL *create_tensor_with_data_as_ort_value)(
        const bn_ort_memory_info *memory, void *data, size_t data_size, const int64_t *shape,
        size_t shape_count, int element_type, bn_ort_value **value);
    bn_ort_gap gap_50[5];
    bn_ort_status *(BN_ORT_CALL *cast_type_info_to_tensor_info)(const bn_ort_type_info *type,
                                                                const bn_ort_tensor_info **tensor);
    bn_ort_gap gap_56[4];
    bn_ort_status *(BN_ORT_CALL *get_tensor_element_type)(const bn_ort_tensor_info *tensor,
                                                          int *element_type);
    bn_ort_status *(BN_ORT_CALL *get_dimensions_count)(const bn_ort_tensor_info *tensor,
                                                       size_t *count);
    bn_ort_status *(BN_ORT_CALL *get_dimensions)(const bn_ort_tensor_info *tensor, int64_t *extents,
                                                 size_t count);
    bn_ort_gap gap_63[6];
    bn_ort_status *(BN_ORT_CALL *create_cpu_memory_info)(int allocator, int memory_type,
                                                         bn_ort_memory_info **memory);
    bn_ort_gap gap_70[6];
    bn_ort_status *(BN_ORT_CALL *allocator_free)(bn_ort_allocator *allocator, void *memory);
    bn_ort_gap gap_77[1];
    bn_ort_status *(BN_ORT_CALL *get_allocator_with_default_options)(bn_ort_allocator **allocator);
    bn_ort_gap gap_79[13];
    void(BN_ORT_CALL *release_env)(bn_ort_env *env);
    void(BN_ORT_CALL *release_status)(bn_ort_status *status);
    void(BN_ORT_CALL *release_memory_info)(bn_ort_memory_info *memory);
    void(BN_ORT_CALL *release_session)(bn_ort_session *session);
    void(BN_ORT_CALL *release_value)(bn_ort_value *value);
    bn_ort_gap gap_97[1];
    void(BN_ORT_CALL *release_type_info)(bn_ort_type_info *type);
    bn_ort_gap gap_99[1];
    void(BN_ORT_CALL *release_session_options)(bn_ort_session_options *options);
    bn_ort_gap gap_101[10];
    bn_ort_status *(BN_ORT_CALL *session_get_model_metadata)(const bn_ort_session *session,
                                                             bn_ort_model_metadata **metadata);
    bn_ort_gap gap_112[4];
    bn_ort_status *(BN_ORT_CALL *model_metadata_lookup_custom_metadata_map)(
        const bn_ort_model_metadata *metadata, bn_ort_allocator *allocator, const char *key,
        char **value);
    bn_ort_gap gap_117[1];
    void(BN_ORT_CALL *release_model_metadata)(bn_ort_model_metadata *metadata);
    bn_ort_gap gap_119[11];
    bn_ort_status *(BN_ORT_CALL *add_session_config_entry)(bn_ort_session_options *options,
                                                           const char *key, const char *value);
    bn_ort_gap gap_131[73];
    bn_ort_status *(BN_ORT_CALL *session_options_append_execution_provider_cuda_v2)(
        bn_ort_session_options *options, const bn_ort_cuda_options *cuda);
    bn_ort_status *(BN_ORT_CALL *create_cuda_provider_options)(bn_ort_cuda_options **cuda);
    bn_ort_status *(BN_ORT_CALL *update_cuda_provider_options)(bn_ort_cuda_options *cuda,
                                                               const char *const *keys,
                                                               const char *const *values,
                                                               size_t count);
    bn_ort_gap gap_207[1];
    void(BN_ORT_CALL *release_cuda_provider_options)(bn_ort_cuda_options *cuda);
} bn_ort_api;

_Static_assert(offsetof(bn_ort_api, release_cuda_provider_options) == 208 * sizeof(bn_ort_gap),
               "an entry or a gap is missing");

/* The result of OrtGetApiBase(), the library's only exported function. */
typedef struct bn_ort_api_base {
    const bn_ort_api *(BN_ORT_CALL *get_api)(uint32_t version);
    const char *(BN_ORT_CALL *get_version_string)(void);
} bn_ort_api_base;

typedef const bn_ort_api_base *(BN_ORT_CALL *bn_ort_get_api_base)(void);

#endif
