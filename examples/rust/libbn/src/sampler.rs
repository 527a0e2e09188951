// SPDX-License-Identifier: Apache-2.0
//! Samplers, domains and blocks of samples.

use crate::Error;
use libbn_sys as sys;
use std::marker::PhantomData;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// The array a draw fills.
pub(crate) fn filled<T: Default + Copy, const N: usize>(draw: impl FnOnce(*mut T)) -> [T; N] {
    let mut out = [T::default(); N];
    draw(out.as_mut_ptr());
    out
}

/// The sampler type; bn.h describes each one.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Type<'a> {
    /// Progressive blue noise: the recommended type.
    Blue,
    Sobol,
    White,
    /// Tuned for a number of samples per pixel; 0 means 256.
    ZOrder {
        samples_per_pixel: u32,
    },
    /// The built-in 64 x 64 mask for the first sample, then Sobol'.
    Mask,
    /// Your own mask, in row-major order: a permutation of 0 to width * height - 1.
    MaskOf {
        ranks: &'a [u32],
        width: u32,
        height: u32,
    },
}

/// Identifies one decision along a path. [`crate::PathSampler`] derives domains for you.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Domain(pub u32);

impl Domain {
    /// The ancestor of all domains.
    pub const ROOT: Domain = Domain(0);

    /// The child for a key. Keys 4*k to 4*k + 3 form a family, whose members are nearly stratified together.
    pub fn child(self, key: u32) -> Domain {
        // SAFETY: a pure function.
        Domain(unsafe { sys::bn_domain_child(self.0, key) })
    }
}

/// A plain value of at most 48 bytes: copy, store and share it between threads. `'m` is the lifetime of your mask.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'m> {
    pub(crate) state: sys::bn_sampler,
    mask: PhantomData<&'m [u32]>,
}

// SAFETY: nothing writes to a sampler or to the ranks it borrows.
unsafe impl Send for Sampler<'_> {}
unsafe impl Sync for Sampler<'_> {}

impl<'m> Sampler<'m> {
    /// A `Blue` sampler. Different seeds give independent images.
    pub fn new(seed: u64) -> Sampler<'static> {
        // SAFETY: a pure function.
        Sampler { state: unsafe { sys::bn_rs_sampler_make(seed) }, mask: PhantomData }
    }

    pub fn with_type(r#type: Type<'m>, seed: u64) -> Result<Sampler<'m>, Error> {
        let mut sampler = Sampler::new(seed);
        let state = &mut sampler.state;
        // SAFETY: a valid sampler; a mask has width * height ranks, which live as long as 'm.
        let result = unsafe {
            match r#type {
                Type::Blue => sys::BN_SUCCESS,
                Type::Sobol => sys::bn_sampler_init(state, sys::BN_SAMPLER_SOBOL, seed),
                Type::White => sys::bn_sampler_init(state, sys::BN_SAMPLER_WHITE, seed),
                Type::ZOrder { samples_per_pixel } => sys::bn_sampler_init_zorder(state, samples_per_pixel, seed),
                Type::Mask => sys::bn_sampler_init(state, sys::BN_SAMPLER_MASK, seed),
                Type::MaskOf { ranks, width, height } => {
                    if u64::from(width) * u64::from(height) != ranks.len() as u64 {
                        return Err(Error::SizeMismatch);
                    }
                    let ranks = ranks.as_ptr().cast();
                    let mask = sys::bn_mask { ranks, rank_bits: 32, width, height, depth: 1, channels: 1 };
                    sys::bn_sampler_init_mask(state, &mask, seed)
                }
            }
        };
        Error::check(result)?;
        Ok(sampler)
    }

    /// The four numbers of sample `index` of pixel (x, y) in a domain.
    pub fn sample_4d(&self, x: i32, y: i32, index: u32, domain: Domain) -> [f32; 4] {
        // SAFETY: a valid sampler, and room for four.
        filled(|out| unsafe { sys::bn_sample_4d(&self.state, x, y, index, domain.0, out) })
    }

    /// One of the two pairs: the first if `pair` is 0, the second if it is 1.
    pub fn sample_2d(&self, x: i32, y: i32, index: u32, domain: Domain, pair: u32) -> [f32; 2] {
        // SAFETY: as above.
        filled(|out| unsafe { sys::bn_sample_2d(&self.state, x, y, index, domain.0, pair, out) })
    }

    /// The four numbers with 32 random bits each.
    pub fn sample_4d_u32(&self, x: i32, y: i32, index: u32, domain: Domain) -> [u32; 4] {
        // SAFETY: as above.
        filled(|out| unsafe { sys::bn_sample_4d_u32(&self.state, x, y, index, domain.0, out) })
    }

    /// All samples in a rectangle of pixels, ordered by row, pixel and index. Faster than single draws.
    pub fn block(&self, x: Range<i32>, y: Range<i32>, index: Range<u32>, domain: Domain) -> Result<Vec<[f32; 4]>, Error> {
        let width = extent(&x)?;
        let height = extent(&y)?;
        let depth = index.end.checked_sub(index.start).filter(|&n| n > 0).ok_or(Error::InvalidArgument)?;
        let count = [width, height, depth].iter().try_fold(1usize, |n, &extent| n.checked_mul(extent as usize));
        let count = count.ok_or(Error::OutOfMemory)?;
        let mut samples: Vec<[f32; 4]> = Vec::new();
        samples.try_reserve_exact(count).map_err(|_| Error::OutOfMemory)?;
        samples.resize(count, [0.0; 4]);
        // SAFETY: a valid sampler, and room for 4 * count.
        Error::check(unsafe {
            sys::bn_sample_block(
                &self.state,
                x.start,
                y.start,
                width,
                height,
                index.start,
                depth,
                domain.0,
                samples.as_mut_ptr().cast(),
                4 * count,
            )
        })?;
        Ok(samples)
    }

    /// Sample `index[i]` of pixel `(x[i], y[i])` in `domain[i]` for each lane i of a wavefront, in any order.
    pub fn sample_wavefront(
        &self,
        x: &[i32],
        y: &[i32],
        index: &[u32],
        domain: &[Domain],
        out: &mut [[f32; 4]],
    ) -> Result<(), Error> {
        let count = out.len();
        if [x.len(), y.len(), index.len(), domain.len()] != [count; 4] {
            return Err(Error::SizeMismatch);
        }
        let lanes = out.as_mut_ptr().cast::<f32>();
        let wavefront = sys::bn_wavefront {
            struct_size: std::mem::size_of::<sys::bn_wavefront>(),
            count,
            x: x.as_ptr(),
            y: y.as_ptr(),
            index: index.as_ptr(),
            domain: domain.as_ptr().cast(),
            shared_index: 0,
            shared_domain: 0,
            depth: null(),
            out: [lanes, lanes.wrapping_add(1), lanes.wrapping_add(2), lanes.wrapping_add(3)],
            stride: 4,
        };
        // SAFETY: all have `count` elements; a Domain is a u32.
        Error::check(unsafe { sys::bn_sample_wavefront(&self.state, &wavefront) })
    }

    /// The two-word seed for shaders (see libbn's docs/shaders.md).
    pub fn seed(&self) -> [u32; 2] {
        self.state.seed
    }
}

/// `Type::Blue`'s table for shaders, which is the same for every seed.
pub fn tables() -> &'static [u32] {
    let mut count = 0;
    // SAFETY: bn_tables() returns `count` constant words.
    unsafe { std::slice::from_raw_parts(sys::bn_tables(&mut count, null_mut()), count) }
}

fn extent(range: &Range<i32>) -> Result<u32, Error> {
    u32::try_from(i64::from(range.end) - i64::from(range.start)).ok().filter(|&n| n > 0).ok_or(Error::InvalidArgument)
}
