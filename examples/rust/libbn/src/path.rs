// SPDX-License-Identifier: Apache-2.0
//! The decisions of a path: every number by what it is for, so that no two decisions share one.
// SAFETY of all draws below: the sampler lives as long as `'s`.

use crate::sampler::{filled, Sampler};
use libbn_sys as sys;

/// One sample of one pixel. It is a name alone: copies name the same numbers.
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

    /// Frames that must be independent have numbers of their own; where frames are averaged, the index goes on instead.
    pub fn in_stream(sampler: &'s Sampler<'s>, x: i32, y: i32, index: u32, stream: u32) -> PathSampler<'s> {
        // SAFETY: a pure function.
        PathSampler { sampler, state: unsafe { sys::bn_rs_path_start(x, y, index, stream) } }
    }

    /// RaySampler 0 leaves the camera, ray d the d-th surface. Make one [`RaySampler`] for each: a second one of the same number starts
    /// again.
    pub fn ray(&self, number: u32) -> RaySampler<'s> {
        // SAFETY: a pure function.
        RaySampler { sampler: self.sampler, state: unsafe { sys::bn_rs_path_ray(&self.state, number) } }
    }

    /// The light tried where ray 0 ends, if a lens has taken its pair; point k if it is split into `count`.
    pub fn first_light(&self, count: u32, k: u32) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_path_first_light(&self.sampler.state, &self.state, count, k, out) })
    }

    /// The time of the path, where things move, and its wavelength.
    pub fn time_wavelength(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_path_time_wavelength(&self.sampler.state, &self.state, out) })
    }
}

/// One ray of a path. It counts what it hands out, so it moves and cannot be copied, since a copy would hand out the same
/// numbers twice: lend it as `&mut`.
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
    /// Where the ray goes, and the light that is tried where it ends. The same at every call.
    pub fn draw(&self) -> [f32; 4] {
        filled(|out| unsafe { sys::bn_rs_ray_draw(&self.sampler.state, &self.state, out) })
    }

    /// The first pair of them alone.
    pub fn draw_direction(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_direction(&self.sampler.state, &self.state, out) })
    }

    /// The second pair of them alone.
    pub fn draw_end_light(&self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_end_light(&self.sampler.state, &self.state, out) })
    }

    /// Single number `k` of the ray, from 0, by an explicit counter: what call k + 1 of [`next_1d`](RaySampler::next_1d) gives. The
    /// same at every call, and so are its relatives. A loop and a split of the same `k` are one decision.
    pub fn draw_1d(&self, k: u32) -> f32 {
        unsafe { sys::bn_rs_ray_draw_1d(&self.sampler.state, &self.state, k) }
    }

    /// Pair `k`.
    pub fn draw_2d(&self, k: u32) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_draw_2d(&self.sampler.state, &self.state, k, out) })
    }

    /// Four `k`.
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

    /// The next single number. Numbers for further decisions are new at every call.
    pub fn next_1d(&mut self) -> f32 {
        unsafe { sys::bn_rs_ray_next_1d(&self.sampler.state, &mut self.state) }
    }

    /// The next pair.
    pub fn next_2d(&mut self) -> [f32; 2] {
        filled(|out| unsafe { sys::bn_rs_ray_next_2d(&self.sampler.state, &mut self.state, out) })
    }

    /// The next four: two pairs whose effects multiply, or a number, the third, and a pair, the first two.
    pub fn next_4d(&mut self) -> [f32; 4] {
        filled(|out| unsafe { sys::bn_rs_ray_next_4d(&self.sampler.state, &mut self.state, out) })
    }

    /// The path goes on in `count` ways, as many as in all samples of the pixel.
    pub fn next_split(&mut self, count: u32) -> Split<'s> {
        Split { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_next_split(&mut self.state, count) } }
    }

    /// It goes on in any number of ways: `first` is how many the earlier samples of the pixel took here.
    pub fn next_split_from(&mut self, first: u32) -> Split<'s> {
        Split { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_next_split_from(&mut self.state, first) } }
    }

    /// The numbers of a loop without bound, such as tracking through a medium.
    pub fn next_loop(&mut self) -> LoopSampler {
        LoopSampler { state: unsafe { sys::bn_rs_ray_next_loop(&self.sampler.state, &mut self.state) } }
    }

    /// A part with a key, such as the number of a primitive that may be transparent. It draws like a ray of its own, and
    /// does not depend on what was drawn before it. A second part of the same key starts again.
    pub fn child(&self, key: u32) -> RaySampler<'s> {
        RaySampler { sampler: self.sampler, state: unsafe { sys::bn_rs_ray_child(&self.state, key) } }
    }
}

/// A path that goes on in several ways.
#[derive(Debug)]
pub struct Split<'s> {
    sampler: &'s Sampler<'s>,
    state: sys::bn_split,
}

impl<'s> Split<'s> {
    /// Branch k, a path of its own whose rays begin at 0. Paths may take fewer branches than `next_split` said, or more.
    pub fn path(&self, k: u32) -> PathSampler<'s> {
        PathSampler { sampler: self.sampler, state: unsafe { sys::bn_rs_split_path(&self.state, k) } }
    }

    /// The first `count` branches.
    pub fn paths(&self, count: u32) -> impl Iterator<Item = PathSampler<'s>> + '_ {
        (0..count).map(move |k| self.path(k))
    }
}

/// The numbers of a loop without bound: four of the sampler's, then a generator's. Like a [`RaySampler`], it cannot be copied.
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
