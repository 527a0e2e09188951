// SPDX-License-Identifier: Apache-2.0
//! Blue-noise random numbers for path tracers: libbn's samplers and paths.
//!
//! ```
//! use libbn::{PathSampler, Sampler};
//!
//! fn trace(sampler: &Sampler, x: i32, y: i32, index: u32) -> f32 {
//!     let path = PathSampler::new(sampler, x, y, index);
//!     let mut sum = 0.0;
//!     for depth in 0..8 {
//!         let mut ray = path.ray(depth); // ray 0 leaves the camera, ray d the d-th surface
//!         let [u, v, s, t] = ray.draw(); // its direction; the light sample at its end
//!         sum += u * v + s * t + ray.next_1d() * ray.next_1d(); // ... your renderer
//!     }
//!     sum
//! }
//! # let sampler = Sampler::new(1);
//! # assert_eq!(trace(&sampler, 3, 4, 5), trace(&sampler, 3, 4, 5));
//! ```
//!
//! All numbers are in [0, 1) and are bit-identical to those in C. A [`Sampler`] is a small immutable value. Draws
//! cannot fail, allocate nothing and take no locks. libbn's docs/paths.md goes through a renderer's decisions.

mod path;
mod sampler;

pub use path::{frame_index, frame_stream, LoopSampler, Pan, PathSampler, RaySampler, Split};
pub use sampler::{tables, Domain, Sampler, Type};

use libbn_sys as sys;
use std::ffi::CStr;
use std::fmt;

/// Why a call failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A count or an extent is zero, or a block runs past the last coordinate or index.
    InvalidArgument,
    /// Slices have different lengths.
    SizeMismatch,
    OutOfMemory,
    /// A mask's ranks are not a permutation.
    BadData,
    Unsupported,
    /// Any other result code of bn.h.
    Other(i32),
}

const ERRORS: [(i32, Error); 5] = [
    (sys::BN_ERROR_INVALID_ARGUMENT, Error::InvalidArgument),
    (sys::BN_ERROR_SIZE_MISMATCH, Error::SizeMismatch),
    (sys::BN_ERROR_OUT_OF_MEMORY, Error::OutOfMemory),
    (sys::BN_ERROR_BAD_DATA, Error::BadData),
    (sys::BN_ERROR_UNSUPPORTED, Error::Unsupported),
];

impl Error {
    fn check(result: i32) -> Result<(), Error> {
        if result == sys::BN_SUCCESS {
            return Ok(());
        }
        Err(ERRORS.into_iter().find(|&(code, _)| code == result).map_or(Error::Other(result), |(_, error)| error))
    }

    /// The result code, BN_ERROR_... in bn.h.
    pub fn code(self) -> i32 {
        match self {
            Error::Other(code) => code,
            known => ERRORS.into_iter().find(|&(_, error)| error == known).expect("a known error").0,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        // SAFETY: never null, and the text is constant.
        let text = unsafe { CStr::from_ptr(sys::bn_result_string(self.code())) };
        f.write_str(&text.to_string_lossy())
    }
}

impl std::error::Error for Error {}
