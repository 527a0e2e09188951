# SPDX-License-Identifier: Apache-2.0
"""Runs a shader with input buffers 0, 1, ... and returns its result. Each thread writes one part of the result.

Compute shaders write the result to the last buffer: WGSL and SPIR-V through wgpu, GLSL through OpenGL, HLSL on the CPU through Slang,
and CUDA on its devices. Fragment shaders read textures instead of buffers, and their pixels are the result.
"""

import ctypes
import functools
from pathlib import Path

import numpy as np

GROUP = 64  # threads per work group in all shaders of this folder


def run_wgpu(code, buffers: list, result_size: int, threads: int, adapter=None) -> bytes:
    import wgpu

    device = (adapter or wgpu.gpu.request_adapter_sync()).request_device_sync()
    made = [{"buffer": device.create_buffer_with_data(data=data, usage=wgpu.BufferUsage.STORAGE)} for data in buffers]
    result = device.create_buffer(size=result_size, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    pipeline = device.create_compute_pipeline(layout="auto", compute={
        "module": device.create_shader_module(code=code), "entry_point": "main"})
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=[
        {"binding": i, "resource": each} for i, each in enumerate([*made, {"buffer": result}])])
    encoder = device.create_command_encoder()
    work = encoder.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, group)
    work.dispatch_workgroups(-(-threads // GROUP))
    work.end()
    device.queue.submit([encoder.finish()])
    return bytes(device.queue.read_buffer(result))


def run_opengl(code: str, buffers: list, result_size: int, threads: int) -> bytes:
    import moderngl

    context = moderngl.create_standalone_context(backend="egl")
    made = [context.buffer(data) for data in buffers] + [context.buffer(reserve=result_size)]
    for i, buffer in enumerate(made):
        buffer.bind_to_storage_buffer(i)
    context.compute_shader(code).run(-(-threads // GROUP))
    return made[-1].read()


TRIANGLE = """
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }"""


def run_fragments(code: str, textures: dict, width: int, result_size: int) -> bytes:
    """Renders an image of 32-bit numbers, `width` pixels wide. `textures`: {name: (width, number type, data)}."""
    import moderngl

    context = moderngl.create_standalone_context(backend="egl")
    program = context.program(vertex_shader=code.split("\n", 1)[0] + TRIANGLE, fragment_shader=code)
    for unit, (name, (columns, kind, data)) in enumerate(textures.items()):
        rows = -(-len(data) // (4 * columns))
        texture = context.texture((columns, rows), 1, data.ljust(4 * columns * rows, b"\0"), dtype=kind)
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        texture.use(unit)
        program[name] = unit
    rows = -(-result_size // (4 * width))
    picture = context.framebuffer([context.texture((width, rows), 1, dtype="u4")])
    picture.use()
    context.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return picture.read(components=1, dtype="u4")[:result_size]


def run_slang(path: Path, buffers: list, result_size: int, threads: int) -> bytes:
    """Runs HLSL on the CPU, compiled by Slang. The file's entry point must be called draw_all, not main."""
    import slangpy

    device = slangpy.Device(type=slangpy.DeviceType.cpu, compiler_options={"include_paths": [str(path.parent)]})
    kernel = device.create_compute_kernel(device.load_program(path.name, ["draw_all"]))
    usage = slangpy.BufferUsage.shader_resource | slangpy.BufferUsage.unordered_access
    made = [device.create_buffer(size=len(data), struct_size=4, usage=usage, data=np.frombuffer(data, "<u4").copy())
            for data in [*buffers, bytes(result_size)]]
    kernel.dispatch(thread_count=[threads, 1, 1], vars=dict(zip(("bn_words", "bn_cdf", "cases", "results"), made)))
    return made[-1].to_numpy().tobytes()


@functools.cache
def cuda_driver():
    return ctypes.CDLL("libcuda.so.1")


def cuda(function: str, *arguments) -> None:
    if status := getattr(cuda_driver(), function)(*arguments):
        raise RuntimeError(f"{function} returned {status}")


def cuda_devices():
    """Yields (number, name, architecture) for each CUDA device. Yields nothing if no driver starts."""
    try:
        cuda("cuInit", 0)
    except (OSError, RuntimeError):
        return
    count, device, name, major, minor = ctypes.c_int(), ctypes.c_int(), ctypes.create_string_buffer(256), ctypes.c_int(), ctypes.c_int()
    cuda("cuDeviceGetCount", ctypes.byref(count))
    for number in range(count.value):
        cuda("cuDeviceGet", ctypes.byref(device), number)
        cuda("cuDeviceGetName", name, len(name), device)
        for part, attribute in ((major, 75), (minor, 76)):
            cuda("cuDeviceGetAttribute", ctypes.byref(part), attribute, device)
        yield device.value, name.value.decode(), f"sm_{major.value}{minor.value}"


def run_cuda(code: bytes, buffers: list, result_size: int, threads: int, device: int) -> bytes:
    """`code`: a module whose kernel `draw` takes the buffers and a case number. It runs as a single thread per case."""
    context, module, kernel = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
    cuda("cuDevicePrimaryCtxRetain", ctypes.byref(context), device)
    cuda("cuCtxSetCurrent", context)
    cuda("cuModuleLoadData", ctypes.byref(module), code)
    cuda("cuModuleGetFunction", ctypes.byref(kernel), module, b"draw")
    made = []
    for data in [*buffers, bytes(result_size)]:
        made.append(ctypes.c_uint64())
        cuda("cuMemAlloc_v2", ctypes.byref(made[-1]), ctypes.c_size_t(len(data)))
        cuda("cuMemcpyHtoD_v2", made[-1], data, ctypes.c_size_t(len(data)))
    number = ctypes.c_uint32()
    arguments = (ctypes.c_void_p * (len(made) + 1))(*map(ctypes.addressof, [*made, number]))
    for number.value in range(threads):
        cuda("cuLaunchKernel", kernel, 1, 1, 1, 1, 1, 1, 0, None, arguments, None)
    result = ctypes.create_string_buffer(result_size)
    cuda("cuMemcpyDtoH_v2", result, made[-1], ctypes.c_size_t(result_size))
    cuda("cuDevicePrimaryCtxRelease_v2", device)
    return result.raw
