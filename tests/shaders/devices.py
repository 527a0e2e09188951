# SPDX-License-Identifier: Apache-2.0
"""Runs a shader over buffers 0, 1 ... and returns a result of which each thread writes its part.

A compute shader writes the last buffer: WGSL with wgpu, SPIR-V with Vulkan, GLSL with OpenGL, HLSL with Slang on the CPU.
A fragment shader reads textures in place of buffers, and its pixels are the result.
"""

from pathlib import Path

import numpy as np

GROUP = 64  # threads of a work group, as in the shaders here


def run_wgsl(code: str, buffers: list, result_size: int, threads: int) -> bytes:
    import wgpu

    device = wgpu.gpu.request_adapter_sync().request_device_sync()
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


def run_spirv(code: bytes, buffers: list, result_size: int, threads: int) -> bytes:
    import vulkan as vk

    instance = _instance(vk)
    device = None
    try:
        physical = vk.vkEnumeratePhysicalDevices(instance)[0]
        device = vk.vkCreateDevice(physical, vk.VkDeviceCreateInfo(pQueueCreateInfos=[
            vk.VkDeviceQueueCreateInfo(queueFamilyIndex=0, pQueuePriorities=[1.0])]), None)
        return _dispatch(vk, physical, device, code, buffers, result_size, threads)
    finally:
        if device is not None:
            vk.vkDestroyDevice(device, None)
        vk.vkDestroyInstance(instance, None)


def _instance(vk):
    about = vk.VkApplicationInfo(apiVersion=vk.VK_MAKE_VERSION(1, 1, 0))
    return vk.vkCreateInstance(vk.VkInstanceCreateInfo(pApplicationInfo=about), None)


def _dispatch(vk, physical, device, code, buffers, result_size, threads):
    """What it makes goes with the device; the process of a test is short."""
    made = [_buffer(vk, physical, device, data, len(data)) for data in buffers]
    made.append(_buffer(vk, physical, device, None, result_size))
    count = len(made)
    kind = vk.VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
    bindings = [vk.VkDescriptorSetLayoutBinding(binding=i, descriptorType=kind, descriptorCount=1,
                                                stageFlags=vk.VK_SHADER_STAGE_COMPUTE_BIT) for i in range(count)]
    set_layout = vk.vkCreateDescriptorSetLayout(
        device, vk.VkDescriptorSetLayoutCreateInfo(pBindings=bindings), None)
    layout = vk.vkCreatePipelineLayout(device, vk.VkPipelineLayoutCreateInfo(pSetLayouts=[set_layout]), None)
    module = vk.vkCreateShaderModule(device, vk.VkShaderModuleCreateInfo(codeSize=len(code), pCode=code), None)
    # Structures have names here so that they outlive the calls: the package copies them without what they point to.
    stage = vk.VkPipelineShaderStageCreateInfo(stage=vk.VK_SHADER_STAGE_COMPUTE_BIT, module=module, pName="main")
    pipelines = vk.vkCreateComputePipelines(device, None, 1, [
        vk.VkComputePipelineCreateInfo(layout=layout, stage=stage)], None)
    pool = vk.vkCreateDescriptorPool(device, vk.VkDescriptorPoolCreateInfo(
        maxSets=1, pPoolSizes=[vk.VkDescriptorPoolSize(type=kind, descriptorCount=count)]), None)
    (group,) = vk.vkAllocateDescriptorSets(device, vk.VkDescriptorSetAllocateInfo(
        descriptorPool=pool, pSetLayouts=[set_layout]))
    whole = [vk.VkDescriptorBufferInfo(buffer=buffer, offset=0, range=size) for buffer, _, size in made]
    writes = [vk.VkWriteDescriptorSet(dstSet=group, dstBinding=i, descriptorCount=1, descriptorType=kind,
                                      pBufferInfo=[each]) for i, each in enumerate(whole)]
    vk.vkUpdateDescriptorSets(device, count, writes, 0, None)

    commands = vk.vkCreateCommandPool(device, vk.VkCommandPoolCreateInfo(queueFamilyIndex=0), None)
    (command,) = vk.vkAllocateCommandBuffers(device, vk.VkCommandBufferAllocateInfo(
        commandPool=commands, level=vk.VK_COMMAND_BUFFER_LEVEL_PRIMARY, commandBufferCount=1))
    vk.vkBeginCommandBuffer(command, vk.VkCommandBufferBeginInfo())
    vk.vkCmdBindPipeline(command, vk.VK_PIPELINE_BIND_POINT_COMPUTE, pipelines[0])
    vk.vkCmdBindDescriptorSets(command, vk.VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, [group], 0, None)
    vk.vkCmdDispatch(command, -(-threads // GROUP), 1, 1)
    vk.vkEndCommandBuffer(command)
    queue = vk.vkGetDeviceQueue(device, 0, 0)
    vk.vkQueueSubmit(queue, 1, [vk.VkSubmitInfo(pCommandBuffers=[command])], None)
    vk.vkDeviceWaitIdle(device)
    return bytes(vk.vkMapMemory(device, made[-1][1], 0, result_size, 0))


def _buffer(vk, physical, device, data, size):
    """A buffer, its memory, which the host sees, and its size."""
    buffer = vk.vkCreateBuffer(device, vk.VkBufferCreateInfo(
        size=size, usage=vk.VK_BUFFER_USAGE_STORAGE_BUFFER_BIT), None)
    wants = vk.vkGetBufferMemoryRequirements(device, buffer)
    visible = vk.VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | vk.VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
    types = vk.vkGetPhysicalDeviceMemoryProperties(physical).memoryTypes
    index = next(i for i, each in enumerate(types)
                 if wants.memoryTypeBits >> i & 1 and each.propertyFlags & visible == visible)
    memory = vk.vkAllocateMemory(device, vk.VkMemoryAllocateInfo(allocationSize=wants.size, memoryTypeIndex=index), None)
    vk.vkBindBufferMemory(device, buffer, memory, 0)
    if data is not None:
        vk.vkMapMemory(device, memory, 0, size, 0)[:] = data
        vk.vkUnmapMemory(device, memory)
    return buffer, memory, size


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
    """Draws a picture of 32-bit numbers, `width` wide. `textures`: {name: (width, type of numbers, data)}."""
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
    """HLSL, compiled by Slang for the CPU. The file must call its entry point other than main."""
    import slangpy

    device = slangpy.Device(type=slangpy.DeviceType.cpu, compiler_options={"include_paths": [str(path.parent)]})
    kernel = device.create_compute_kernel(device.load_program(path.name, ["draw_all"]))
    usage = slangpy.BufferUsage.shader_resource | slangpy.BufferUsage.unordered_access
    made = [device.create_buffer(size=len(data), struct_size=4, usage=usage, data=np.frombuffer(data, "<u4").copy())
            for data in [*buffers, bytes(result_size)]]
    kernel.dispatch(thread_count=[threads, 1, 1], vars=dict(zip(("bn_words", "bn_cdf", "cases", "results"), made)))
    return made[-1].to_numpy().tobytes()


def main():
    """Prints what the functions above run on."""
    import moderngl
    import vulkan as vk
    import wgpu

    adapter = wgpu.gpu.request_adapter_sync().info
    print(f"wgpu {wgpu.__version__}: {adapter['device']}, {adapter['backend_type']}, {adapter['description']}")
    instance = _instance(vk)
    found = vk.vkGetPhysicalDeviceProperties(vk.vkEnumeratePhysicalDevices(instance)[0])
    print(f"Vulkan: {found.deviceName}")
    vk.vkDestroyInstance(instance, None)
    about = moderngl.create_standalone_context(backend="egl").info
    print(f"OpenGL: {about['GL_RENDERER']}, {about['GL_VERSION']}")


if __name__ == "__main__":
    main()
