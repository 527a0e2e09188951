/* SPDX-License-Identifier: Apache-2.0
 * The entries of ONNX Runtime's C API that libbn declares have the offsets of the real header.
 * Skipped (exit status 77) without a header; BN_ONNXRUNTIME_INCLUDE_DIR names its folder. */
#include <stdio.h>

#ifndef BN_HAVE_ONNXRUNTIME_HEADER

int main(void) {
    printf("no onnxruntime_c_api.h at hand\n");
    return 77;
}

#else

#include "../../libbn/src/neural/onnxruntime_api.h"
#include "check.h"
#include <onnxruntime_c_api.h>

#define CHECK_ENTRY(ours, theirs) CHECK(offsetof(bn_ort_api, ours) == offsetof(OrtApi, theirs))

int main(void) {
    CHECK_ENTRY(get_error_code, GetErrorCode);
    CHECK_ENTRY(create_env, CreateEnv);
    CHECK_ENTRY(disable_telemetry_events, DisableTelemetryEvents);
    CHECK_ENTRY(create_session_from_array, CreateSessionFromArray);
    CHECK_ENTRY(run, Run);
    CHECK_ENTRY(create_session_options, CreateSessionOptions);
    CHECK_ENTRY(set_session_log_severity_level, SetSessionLogSeverityLevel);
    CHECK_ENTRY(set_session_graph_optimization_level, SetSessionGraphOptimizationLevel);
    CHECK_ENTRY(set_intra_op_num_threads, SetIntraOpNumThreads);
    CHECK_ENTRY(set_inter_op_num_threads, SetInterOpNumThreads);
    CHECK_ENTRY(create_tensor_with_data_as_ort_value, CreateTensorWithDataAsOrtValue);
    CHECK_ENTRY(create_cpu_memory_info, CreateCpuMemoryInfo);
    CHECK_ENTRY(session_get_input_count, SessionGetInputCount);
    CHECK_ENTRY(session_get_output_count, SessionGetOutputCount);
    CHECK_ENTRY(session_get_input_type_info, SessionGetInputTypeInfo);
    CHECK_ENTRY(session_get_output_type_info, SessionGetOutputTypeInfo);
    CHECK_ENTRY(session_get_input_name, SessionGetInputName);
    CHECK_ENTRY(session_get_output_name, SessionGetOutputName);
    CHECK_ENTRY(cast_type_info_to_tensor_info, CastTypeInfoToTensorInfo);
    CHECK_ENTRY(get_tensor_element_type, GetTensorElementType);
    CHECK_ENTRY(get_dimensions_count, GetDimensionsCount);
    CHECK_ENTRY(get_dimensions, GetDimensions);
    CHECK_ENTRY(allocator_free, AllocatorFree);
    CHECK_ENTRY(get_allocator_with_default_options, GetAllocatorWithDefaultOptions);
    CHECK_ENTRY(release_type_info, ReleaseTypeInfo);
    CHECK_ENTRY(session_get_model_metadata, SessionGetModelMetadata);
    CHECK_ENTRY(model_metadata_lookup_custom_metadata_map, ModelMetadataLookupCustomMetadataMap);
    CHECK_ENTRY(release_model_metadata, ReleaseModelMetadata);
    CHECK_ENTRY(release_env, ReleaseEnv);
    CHECK_ENTRY(release_status, ReleaseStatus);
    CHECK_ENTRY(release_memory_info, ReleaseMemoryInfo);
    CHECK_ENTRY(release_session, ReleaseSession);
    CHECK_ENTRY(release_value, ReleaseValue);
    CHECK_ENTRY(release_session_options, ReleaseSessionOptions);
    CHECK_ENTRY(add_session_config_entry, AddSessionConfigEntry);
    CHECK_ENTRY(session_options_append_execution_provider_cuda_v2,
                SessionOptionsAppendExecutionProvider_CUDA_V2);
    CHECK_ENTRY(create_cuda_provider_options, CreateCUDAProviderOptions);
    CHECK_ENTRY(update_cuda_provider_options, UpdateCUDAProviderOptions);
    CHECK_ENTRY(release_cuda_provider_options, ReleaseCUDAProviderOptions);
    CHECK(offsetof(bn_ort_api_base, get_api) == offsetof(OrtApiBase, GetApi));
    CHECK(offsetof(bn_ort_api_base, get_version_string) == offsetof(OrtApiBase, GetVersionString));
    CHECK((int)BN_ORT_LOG_FATAL == (int)ORT_LOGGING_LEVEL_FATAL);
    CHECK((int)BN_ORT_OPTIMISE_ALL == (int)ORT_ENABLE_ALL);
    CHECK((int)BN_ORT_FLOAT == (int)ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT);
    CHECK((int)BN_ORT_ARENA_ALLOCATOR == (int)OrtArenaAllocator);
    CHECK((int)BN_ORT_MEMORY_DEFAULT == (int)OrtMemTypeDefault);
    CHECK((int)BN_ORT_INVALID_PROTOBUF == (int)ORT_INVALID_PROTOBUF);
    CHECK((int)BN_ORT_NOT_IMPLEMENTED == (int)ORT_NOT_IMPLEMENTED);
    CHECK((int)BN_ORT_INVALID_GRAPH == (int)ORT_INVALID_GRAPH);
    return check_result();
}

#endif
