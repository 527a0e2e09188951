# SPDX-License-Identifier: Apache-2.0
# Neural mask tests, included if BN_NEURAL is on.

# The fake ONNX Runtime, built under two names.
if(UNIX AND NOT APPLE)
    foreach(name fake_onnxruntime fake_other)
        add_library(${name} MODULE fake_onnxruntime.c)
        target_compile_features(${name} PRIVATE c_std_11)
        target_link_libraries(${name} PRIVATE bn_build_flags Threads::Threads)
        target_compile_options(${name} PRIVATE -Wno-unused-parameter)
        set_target_properties(${name} PROPERTIES C_VISIBILITY_PRESET hidden)
    endforeach()

    function(bn_add_neural_test name)
        bn_add_c_test(${name})
        target_compile_definitions(${name} PRIVATE BN_FAKE_DIR="${CMAKE_CURRENT_BINARY_DIR}")
        target_link_libraries(${name} PRIVATE ${CMAKE_DL_LIBS})
        add_dependencies(${name} fake_onnxruntime fake_other)
        set_tests_properties(${name} PROPERTIES ENVIRONMENT "ORT_DISABLE_TELEMETRY=1")
    endfunction()
    bn_add_neural_test(test_neural)
    bn_add_neural_test(test_neural_rights)
    set_tests_properties(test_neural_rights PROPERTIES SKIP_RETURN_CODE 77)
endif()
