// SPDX-License-Identifier: Apache-2.0
//! libbn's samplers and paths, declared as in C; bn.h and bn_path.h document them. The names of functions that are
//! inline in bn_path.h start with `bn_rs_`. The `libbn` crate is the safe interface.
#![allow(non_camel_case_types)]

pub const BN_SUCCESS: i32 = 0;
pub const BN_ERROR_INVALID_ARGUMENT: i32 = 1;
pub const BN_ERROR_SIZE_MISMATCH: i32 = 2;
pub const BN_ERROR_OUT_OF_MEMORY: i32 = 3;
pub const BN_ERROR_BAD_DATA: i32 = 4;
pub const BN_ERROR_UNSUPPORTED: i32 = 5;

pub const BN_SAMPLER_BLUE: i32 = 0;
pub const BN_SAMPLER_SOBOL: i32 = 1;
pub const BN_SAMPLER_WHITE: i32 = 2;
pub const BN_SAMPLER_ZORDER: i32 = 3;
pub const BN_SAMPLER_MASK: i32 = 4;

#[repr(C)]
pub struct bn_mask {
    pub ranks: *const std::os::raw::c_void,
    pub rank_bits: u32,
    pub width: u32,
    pub height: u32,
    pub depth: u32,
    pub channels: u32,
}

#[repr(C)]
pub struct bn_wavefront {
    pub struct_size: usize,
    pub count: usize,
    pub x: *const i32,
    pub y: *const i32,
    pub index: *const u32,
    pub domain: *const u32,
    pub shared_index: u32,
    pub shared_domain: u32,
    pub depth: *const u32,
    pub out: [*mut f32; 4],
    pub stride: usize,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct bn_sampler {
    pub r#type: i32,
    pub log2_samples: u32,
    pub seed: [u32; 2],
    pub mask: *const std::os::raw::c_void,
    pub mask_scale: u64,
    pub mask_low_digits: u32,
    pub mask_width: u32,
    pub mask_height: u32,
    pub mask_rank_bits: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct bn_path {
    pub x: u32,
    pub y: u32,
    pub index: u32,
    pub domain: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct bn_pan {
    pub x: u32,
    pub y: u32,
    pub x_rest: u32,
    pub y_rest: u32,
}

#[repr(C)]
#[derive(Debug)]
pub struct bn_ray {
    pub path: bn_path,
    pub domain: u32,
    pub drawn_1d: u32,
    pub drawn_2d: u32,
    pub drawn_4d: u32,
    pub splits: u32,
    pub loops: u32,
    pub next_1d: f32,
}

#[repr(C)]
#[derive(Debug)]
pub struct bn_split {
    pub path: bn_path,
    pub domain: u32,
    pub count: u32,
}

#[repr(C)]
#[derive(Debug)]
pub struct bn_loop {
    pub next: [f32; 4],
    pub counter: [u32; 4],
    pub drawn: u32,
}

extern "C" {
    pub fn bn_result_string(result: i32) -> *const std::os::raw::c_char;
    pub fn bn_domain_child(domain: u32, key: u32) -> u32;

    pub fn bn_sampler_init(sampler: *mut bn_sampler, r#type: i32, seed: u64) -> i32;
    pub fn bn_sampler_init_zorder(sampler: *mut bn_sampler, samples_per_pixel: u32, seed: u64) -> i32;
    pub fn bn_sampler_init_mask(sampler: *mut bn_sampler, mask: *const bn_mask, seed: u64) -> i32;
    pub fn bn_tables(count: *mut usize, version: *mut u32) -> *const u32;
    pub fn bn_sample_4d(sampler: *const bn_sampler, x: i32, y: i32, index: u32, domain: u32, out: *mut f32);
    pub fn bn_sample_4d_u32(sampler: *const bn_sampler, x: i32, y: i32, index: u32, domain: u32, out: *mut u32);
    pub fn bn_sample_2d(sampler: *const bn_sampler, x: i32, y: i32, index: u32, domain: u32, pair: u32, out: *mut f32);
    pub fn bn_sample_block(
        sampler: *const bn_sampler,
        x0: i32,
        y0: i32,
        width: u32,
        height: u32,
        first_index: u32,
        index_count: u32,
        domain: u32,
        out: *mut f32,
        out_count: usize,
    ) -> i32;
    pub fn bn_sample_wavefront(sampler: *const bn_sampler, wavefront: *const bn_wavefront) -> i32;

    pub fn bn_rs_sampler_make(seed: u64) -> bn_sampler;
    pub fn bn_rs_path_start(x: i32, y: i32, index: u32, frame: u32) -> bn_path;
    pub fn bn_rs_follow(pan: bn_pan, x: f32, y: f32) -> bn_pan;
    pub fn bn_rs_frame_index(frame: u32, most: u32) -> u32;
    pub fn bn_rs_frame_stream(frame: u32, most: u32) -> u32;
    pub fn bn_rs_path_ray(path: *const bn_path, ray: u32) -> bn_ray;
    pub fn bn_rs_ray_child(ray: *const bn_ray, key: u32) -> bn_ray;
    pub fn bn_rs_ray_next_split(ray: *mut bn_ray, count: u32) -> bn_split;
    pub fn bn_rs_ray_next_split_from(ray: *mut bn_ray, first: u32) -> bn_split;
    pub fn bn_rs_split_path(split: *const bn_split, k: u32) -> bn_path;
    pub fn bn_rs_ray_draw(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_draw_direction(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_draw_end_light(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_next_1d(sampler: *const bn_sampler, ray: *mut bn_ray) -> f32;
    pub fn bn_rs_ray_next_2d(sampler: *const bn_sampler, ray: *mut bn_ray, out: *mut f32);
    pub fn bn_rs_ray_next_4d(sampler: *const bn_sampler, ray: *mut bn_ray, out: *mut f32);
    pub fn bn_rs_ray_draw_1d(sampler: *const bn_sampler, ray: *const bn_ray, k: u32) -> f32;
    pub fn bn_rs_ray_draw_2d(sampler: *const bn_sampler, ray: *const bn_ray, k: u32, out: *mut f32);
    pub fn bn_rs_ray_draw_4d(sampler: *const bn_sampler, ray: *const bn_ray, k: u32, out: *mut f32);
    pub fn bn_rs_ray_draw_split(ray: *const bn_ray, k: u32, count: u32) -> bn_split;
    pub fn bn_rs_ray_draw_loop(sampler: *const bn_sampler, ray: *const bn_ray, k: u32) -> bn_loop;
    pub fn bn_rs_path_first_light(sampler: *const bn_sampler, path: *const bn_path, count: u32, k: u32, out: *mut f32);
    pub fn bn_rs_path_time_wavelength(sampler: *const bn_sampler, path: *const bn_path, out: *mut f32);
    pub fn bn_rs_ray_next_loop(sampler: *const bn_sampler, ray: *mut bn_ray) -> bn_loop;
    pub fn bn_rs_loop_next_1d(rng: *mut bn_loop) -> f32;
}
