// SPDX-License-Identifier: Apache-2.0
//! Random numbers for a path, requested by purpose so that no two decisions share one.
// SAFETY of all draws below: the sampler lives as long as `'s`.

use crate::sampler::{filled, Sampler};
use libbn_sys as sys;

/// One sample of one pixel. It is stateless: copies return the same numbers.
#[derive(Clone, Copy, Debug)]
pub struct PathSampler<'s> {
    sampler: &'s Sampler<'s>,
    state: sys::bn_path,
}

impl<'s> PathSampler<'s> {
    /// Sample `index` of pixel (x, y) of a single image.
    pub fn new(sampler: &'s Sampler<'s>, x: i32, y: i32, index: u32) -> PathSampler<'s> {
        PathSampler::in_stream(sampler, x, y, index, 0)
    }

    /// Streams are independent: use them for light paths alongside camera paths. Frames share a stream and continue the index.
    pub fn in_stream(sampler: &'s Sampler<'s>, x: i32, y: i32, index: u32, stream: u32) -> PathSampler<'s> {
        // SAFETY: a pure function.
        PathSampler { sampler, state: unsafe { sys::bn_rs_path_start(x, y, index, stream) } }
    }

    /// Ray 0 leaves the camera; ray d leaves the d-th surface. Make one [`RaySampler`] for each: a second one returns the same
    /// numbers again.
    pub fn ray(&self, number: u32) -> RaySampler<'s> {
        // SAFETY: a pure function.
        RaySampler { sampler: self.sampler, state: unsafe { sys::bn_rs_path_ray(&self.state, number) } }
    }

    /// The light sample at the end of ray 0, if a lens uses that ray's second pair; or light sample k of `count`.
    pub fn first_light(&self, count: u32, k: u32) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_path_first_light(&self.sampler.state, &self.state, count, k, out) })
    }

    /// [0]: time as a fraction of the shutter interval. [1]: position in the spectrum.
    pub fn time_wavelength(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_path_time_wavelength(&self.sampler.state, &self.state, out) })
    }
}

/// How far an image has moved, in whole pixels: draw at `(x - pan.x(), y - pan.y())`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pan(sys::bn_pan);

impl Pan {
    /// Call this once per frame: the image moved by (x, y) pixels, in the directions in which coordinates grow. `bn_path.glsl` has
    /// the rules for rounding and for values that are not finite.
    pub fn follow(&mut self, x: f32, y: f32) {
        // SAFETY: a pure function.
        self.0 = unsafe { sys::bn_rs_follow(self.0, x, y) };
    }

    pub fn x(&self) -> i32 {
        self.0.x as i32
    }

    pub fn y(&self) -> i32 {
        self.0.y as i32
    }
}

/// The index of the first sample of a film's frame. `most` is the largest number of samples that a pixel takes in any frame; pass
/// [`frame_stream`] as the stream.
pub fn frame_index(frame: u32, most: u32) -> u32 {
    // SAFETY: a pure function.
    unsafe { sys::bn_rs_frame_index(frame, most) }
}

/// The stream of a film's frame: 0 until the indices are used up.
pub fn frame_stream(frame: u32, most: u32) -> u32 {
    // SAFETY: a pure function.
    unsafe { sys::bn_rs_frame_stream(frame, most) }
}

/// One ray of a path. It is stateful, so it can be moved but not copied, because a copy would return the same numbers again: pass
/// it as `&mut`.
///
/// ```compile_fail,E0599
/// fn twice(ray: libbn::RaySampler) -> (libbn::RaySampler, libbn::RaySampler) {
///     (ray.clone(), ray)
/// }
/// ```
///
/// ```compile_fail,E0515
/// fn dangling() -> libbn::RaySampler<'static> {
///     let sampler = libbn::Sampler::new(1);
///     let path = libbn::PathSampler::new(&sampler, 0, 0, 0);
///     path.ray(0)
/// }
/// ```
#[derive(Debug)]
pub struct RaySampler<'s> {
    sampler: &'s Sampler<'s>,
    state: sys::bn_ray,
}

impl<'s> RaySampler<'s> {
    /// The ray's direction, and the light sample at its end. Every call returns the same four numbers.
    pub fn draw(&self) -> [f32; 4] {
        filled(|out| unsafe { sys::bn_rs_ray_draw(&self.sampler.state, &self.state, out) })
    }

    /// Only the first pair.
    pub fn draw_direction(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_direction(&self.sampler.state, &self.state, out) })
    }

    /// Only the second pair.
    pub fn draw_end_light(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_end_light(&self.sampler.state, &self.state, out) })
    }

    /// Single number `k` of the ray, from 0: the result of call k + 1 of [`next_1d`](RaySampler::next_1d), without advancing the
    /// ray. The functions below do the same for pairs, groups of four, splits and loops.
    pub fn draw_1d(&self, k: u32) -> f32 {
        unsafe { sys::bn_rs_ray_draw_1d(&self.sampler.state, &self.state, k) }
    }

    /// Pair `k` of the ray.
    pub fn draw_2d(&self, k: u32) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_2d(&self.sampler.state, &self.state, k, out) })
    }

    /// The ray's `k`-th group of four numbers.
    pub fn draw_4d(&self, k: u32) -> [f32; 4] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_4d(&self.sampler.state, &self.state, k, out) })
    }

    /// Split `k`, into `count` branches.
    pub fn draw_split(&self, k: u32, count: u32) -> Split<'s> {
        Split { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_draw_split(&self.state, k, count) } }
    }

    /// The numbers of loop `k`.
    pub fn draw_loop(&self, k: u32) -> LoopSampler {
        LoopSampler { state: unsafe { sys::bn_rs_ray_draw_loop(&self.sampler.state, &self.state, k) } }
    }

    /// The next single number, for another decision.
    pub fn next_1d(&mut self) -> f32 {
        unsafe { sys::bn_rs_ray_next_1d(&self.sampler.state, &mut self.state) }
    }

    /// The next pair.
    pub fn next_2d(&mut self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_next_2d(&self.sampler.state, &mut self.state, out) })
    }

    /// The next four numbers: for two pairs whose contributions multiply, or a choice (the third) and a pair (the first two).
    pub fn next_4d(&mut self) -> [f32; 4] {
        filled(|out| unsafe { sys::bn_rs_ray_next_4d(&self.sampler.state, &mut self.state, out) })
    }

    /// Splits the path into `count` branches. The count must be the same for all samples of the pixel.
    pub fn next_split(&mut self, count: u32) -> Split<'s> {
        Split { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_next_split(&mut self.state, count) } }
    }

    /// Splits the path into any number of branches. `first` is the number the pixel's earlier samples took here.
    pub fn next_split_from(&mut self, first: u32) -> Split<'s> {
        Split { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_next_split_from(&mut self.state, first) } }
    }

    /// Random numbers for a loop of unknown length, such as delta tracking.
    pub fn next_loop(&mut self) -> LoopSampler {
        LoopSampler { state: unsafe { sys::bn_rs_ray_next_loop(&self.sampler.state, &mut self.state) } }
    }

    /// A sub-sampler of the ray, selected by a key such as a primitive's index. Draw from it as you would from a ray. Its
    /// numbers do not depend on earlier draws: a second child with the same key returns the same numbers again.
    pub fn child(&self, key: u32) -> RaySampler<'s> {
        RaySampler { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_child(&self.state, key) } }
    }
}

/// A path that continues in multiple branches.
#[derive(Debug)]
pub struct Split<'s> {
    sampler: &'s Sampler<'s>,
    state: sys::bn_split,
}

impl<'s> Split<'s> {
    /// Branch k, which is a path whose rays start at 0. A path may use fewer or more branches than the count passed to
    /// `next_split`.
    pub fn path(&self, k: u32) -> PathSampler<'s> {
        PathSampler { sampler: self.sampler, state: unsafe { sys::bn_rs_split_path(&self.state, k) } }
    }

    /// The first `count` branches.
    pub fn paths(&self, count: u32) -> impl Iterator<Item = PathSampler<'s>> + '_ {
        (0..count).map(move |k| self.path(k))
    }
}

/// Random numbers for a loop of unknown length: the first four are stratified, the rest pseudo-random. It cannot be copied.
#[derive(Debug)]
pub struct LoopSampler {
    state: sys::bn_loop,
}

impl LoopSampler {
    /// The next number.
    pub fn next_1d(&mut self) -> f32 {
        unsafe { sys::bn_rs_loop_next_1d(&mut self.state) }
    }
}

impl Iterator for LoopSampler {
    type Item = f32;

    fn next(&mut self) -> Option<f32> {
        Some(self.next_1d())
    }
}
