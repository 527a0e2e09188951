// SPDX-License-Identifier: Apache-2.0
//! The samplers and paths of libbn as C has them: bn.h and bn_path.h are the manuals. Functions that are inline in
//! bn_path.h begin with `bn_rs_`. The crate `bluenoise` is safe.
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
pub struct bn_sampler_options {
    pub struct_size: usize,
    pub kind: i32,
    pub samples_per_pixel: u32,
    pub seed: u64,
    pub mask_ranks: *const u32,
    pub mask_width: u32,
    pub mask_height: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct bn_sampler {
    pub kind: i32,
    pub log2_samples: u32,
    pub seed: [u32; 2],
    pub mask: *const u32,
    pub mask_scale: u64,
    pub mask_low_digits: u32,
    pub mask_width: u32,
    pub mask_height: u32,
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
pub struct bn_rng {
    pub next: [f32; 4],
    pub counter: [u32; 4],
    pub drawn: u32,
}

extern "C" {
    pub fn bn_result_string(result: i32) -> *const std::os::raw::c_char;
    pub fn bn_domain_child(domain: u32, key: u32) -> u32;

    pub fn bn_sampler_init(sampler: *mut bn_sampler, options: *const bn_sampler_options) -> i32;
    pub fn bn_tables(count: *mut usize, version: *mut u32) -> *const u32;
    pub fn bn_sample_4d(sampler: *const bn_sampler, x: i32, y: i32, index: u32, domain: u32, out: *mut f32);
    pub fn bn_sample_4d_u32(sampler: *const bn_sampler, x: i32, y: i32, index: u32, domain: u32, out: *mut u32);
    pub fn bn_sample_pair(
        sampler: *const bn_sampler,
        x: i32,
        y: i32,
        index: u32,
        domain: u32,
        pair: u32,
        out: *mut f32,
    );
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
    pub fn bn_sample_many(
        sampler: *const bn_sampler,
        count: usize,
        x: *const i32,
        y: *const i32,
        index: *const u32,
        domain: *const u32,
        dimensions: u32,
        out: *mut f32,
        out_count: usize,
    ) -> i32;

    pub fn bn_rs_sampler_make(kind: i32, seed: u64) -> bn_sampler;
    pub fn bn_rs_path_start(x: i32, y: i32, index: u32, frame: u32) -> bn_path;
    pub fn bn_rs_path_ray(path: *const bn_path, ray: u32) -> bn_ray;
    pub fn bn_rs_ray_keyed(ray: *const bn_ray, key: u32) -> bn_ray;
    pub fn bn_rs_ray_split(ray: *mut bn_ray, count: u32) -> bn_split;
    pub fn bn_rs_ray_split_from(ray: *mut bn_ray, first: u32) -> bn_split;
    pub fn bn_rs_split_path(split: *const bn_split, k: u32) -> bn_path;
    pub fn bn_rs_ray_draw(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_draw_where(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_draw_light(sampler: *const bn_sampler, ray: *const bn_ray, out: *mut f32);
    pub fn bn_rs_ray_1d(sampler: *const bn_sampler, ray: *mut bn_ray) -> f32;
    pub fn bn_rs_ray_2d(sampler: *const bn_sampler, ray: *mut bn_ray, out: *mut f32);
    pub fn bn_rs_ray_4d(sampler: *const bn_sampler, ray: *mut bn_ray, out: *mut f32);
    pub fn bn_rs_ray_1d_at(sampler: *const bn_sampler, ray: *const bn_ray, k: u32) -> f32;
    pub fn bn_rs_ray_2d_at(sampler: *const bn_sampler, ray: *const bn_ray, k: u32, out: *mut f32);
    pub fn bn_rs_ray_4d_at(sampler: *const bn_sampler, ray: *const bn_ray, k: u32, out: *mut f32);
    pub fn bn_rs_ray_split_at(ray: *const bn_ray, k: u32, count: u32) -> bn_split;
    pub fn bn_rs_ray_rng_at(sampler: *const bn_sampler, ray: *const bn_ray, k: u32) -> bn_rng;
    pub fn bn_rs_path_first_light(sampler: *const bn_sampler, path: *const bn_path, count: u32, k: u32, out: *mut f32);
    pub fn bn_rs_path_time(sampler: *const bn_sampler, path: *const bn_path, out: *mut f32);
    pub fn bn_rs_ray_rng(sampler: *const bn_sampler, ray: *mut bn_ray) -> bn_rng;
    pub fn bn_rs_rng_1d(rng: *mut bn_rng) -> f32;
}
