// SPDX-License-Identifier: Apache-2.0
//! The safe functions return the same bits as C, in the same order.

use libbn::{frame_index, frame_stream, tables, Domain, Error, Pan, PathSampler, Sampler, Type};
use libbn_sys as sys;

/// Calls the C library's bn_sample_4d() without any type or function of the safe crate.
struct C(sys::bn_sampler);

impl C {
    fn new(ty: i32, seed: u64) -> C {
        let mut c = C(unsafe { sys::bn_rs_sampler_make(seed) });
        assert_eq!(unsafe { sys::bn_sampler_init(&mut c.0, ty, seed) }, sys::BN_SUCCESS);
        c
    }

    fn draw(&self, x: i32, y: i32, index: u32, domain: u32) -> [f32; 4] {
        let mut out = [0.0; 4];
        unsafe { sys::bn_sample_4d(&self.0, x, y, index, domain, out.as_mut_ptr()) };
        out
    }
}

fn child(domain: u32, key: u32) -> u32 {
    unsafe { sys::bn_domain_child(domain, key) }
}

const TYPES: [(Type, i32); 5] = [
    (Type::Blue, sys::BN_SAMPLER_BLUE),
    (Type::Sobol, sys::BN_SAMPLER_SOBOL),
    (Type::White, sys::BN_SAMPLER_WHITE),
    (Type::ZOrder { samples_per_pixel: 0 }, sys::BN_SAMPLER_ZORDER),
    (Type::Mask, sys::BN_SAMPLER_MASK),
];
const PLACES: [(i32, i32, u32); 5] =
    [(0, 0, 0), (3, 4, 5), (-7, 200, 300), (i32::MIN, i32::MAX, u32::MAX / 16), (64, -1, 16)];

#[test]
fn samples_are_those_of_c() {
    for (ty, number) in TYPES {
        let (safe, c) = (Sampler::with_type(ty, 9).unwrap(), C::new(number, 9));
        for (x, y, index) in PLACES {
            let domain = Domain::ROOT.child(6).child(index);
            assert_eq!(domain.0, child(child(0, 6), index));
            let expected = c.draw(x, y, index, domain.0);
            assert_eq!(safe.sample_4d(x, y, index, domain), expected);
            assert_eq!(safe.sample_4d_u32(x, y, index, domain).map(|v| (v >> 8) as f32 / 16777216.0), expected);
            assert_eq!(safe.sample_2d(x, y, index, domain, 0), expected[..2]);
            assert_eq!(safe.sample_2d(x, y, index, domain, 1), expected[2..]);
        }
    }
}

// tests/install compares everything that counted draws return with C, using the `draws` example.
#[test]
fn paths_are_those_of_c_and_explicit_counters_those_of_the_calls() {
    for (ty, number) in TYPES {
        let (safe, c) = (Sampler::with_type(ty, 2).unwrap(), C::new(number, 2));
        for (x, y, index) in PLACES {
            for stream in [0, 7] {
                let parent = if stream == 0 { 0 } else { child(child(0, 0x8000_0000), stream) };
                let path = PathSampler::in_stream(&safe, x, y, index, stream);
                assert_eq!(path.time_wavelength(), c.draw(x, y, index, child(parent, 3))[2..]);
                for (count, k) in [(1, 0), (3, 2)] {
                    assert_eq!(path.first_light(count, k), c.draw(x, y, index * count + k, child(parent, 3))[..2]);
                }
                let (ray, mut counted) = (path.ray(2), path.ray(2));
                assert_eq!(ray.draw(), c.draw(x, y, index, child(parent, 2)));
                assert_eq!([ray.draw_direction(), ray.draw_end_light()].concat(), ray.draw());
                for k in 0..5 {
                    assert_eq!(ray.draw_1d(k), counted.next_1d());
                    assert_eq!(ray.draw_2d(k), counted.next_2d());
                    assert_eq!(ray.draw_4d(k), counted.next_4d());
                    assert_eq!(ray.draw_loop(k).next_1d(), counted.next_loop().next_1d());
                    let branch = counted.next_split(4).path(1);
                    assert_eq!(ray.draw_split(k, 4).path(1).ray(0).draw(), branch.ray(0).draw());
                }
            }
        }
    }
}

#[test]
fn blocks_and_wavefronts_are_single_samples() {
    let sampler = Sampler::new(4);
    let domain = Domain::ROOT.child(1);
    let block = sampler.block(-2..3, 5..9, 10..13, domain).unwrap();
    let (mut x, mut y, mut index, mut expected) = (vec![], vec![], vec![], vec![]);
    for (py, px, i) in (5..9).flat_map(|y| (-2..3).flat_map(move |x| (10..13).map(move |i| (y, x, i)))) {
        x.push(px);
        y.push(py);
        index.push(i);
        expected.push(sampler.sample_4d(px, py, i, domain));
    }
    assert_eq!(block, expected);
    let mut out = vec![[9.0; 4]; 60];
    sampler.sample_wavefront(&x, &y, &index, &[domain; 60], &mut out).unwrap();
    assert_eq!(out, expected);
    assert_eq!(sampler.sample_wavefront(&x, &y, &index, &[domain; 59], &mut out), Err(Error::SizeMismatch));
    assert_eq!(sampler.sample_wavefront(&[], &[], &[], &[], &mut []), Ok(()));
    assert_eq!((tables().len(), sampler.seed()), (11904, C::new(0, 4).0.seed));
}

#[test]
fn errors_are_results() {
    let sampler = Sampler::new(0);
    let root = Domain::ROOT;
    #[allow(clippy::reversed_empty_ranges)]
    for (x, y, index) in [(0..0, 0..1, 0..1), (0..1, 1..0, 0..1), (0..1, 0..1, 3..3), (0..1, 0..1, 4..3)] {
        assert_eq!(sampler.block(x, y, index, root).unwrap_err(), Error::InvalidArgument);
    }
    let all = i32::MIN..i32::MAX;
    assert_eq!(sampler.block(all.clone(), all, 0..u32::MAX, root).unwrap_err(), Error::OutOfMemory);
    let mask = |ranks, width, height| Sampler::with_type(Type::MaskOf { ranks, width, height }, 0).map(|_| ());
    assert_eq!(mask(&[0, 3, 2, 1], 2, 2), Ok(()));
    assert_eq!(mask(&[0, 3, 2, 1], 2, 3), Err(Error::SizeMismatch));
    assert_eq!(mask(&[0, 3, 2, 1], u32::MAX, u32::MAX), Err(Error::SizeMismatch));
    assert_eq!(mask(&[0, 3, 3, 1], 2, 2), Err(Error::BadData));
    assert_eq!(mask(&[], 0, 0), Err(Error::InvalidArgument));
    assert!(!Error::BadData.to_string().is_empty() && Error::BadData.to_string() != Error::OutOfMemory.to_string());
}

#[test]
fn threads_share_a_sampler_and_move_rays() {
    let sampler = Sampler::new(5);
    let expected = PathSampler::new(&sampler, 1, 2, 3).ray(0).next_4d();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            let mut ray = PathSampler::new(&sampler, 1, 2, 3).ray(0);
            scope.spawn(move || assert_eq!(ray.next_4d(), expected));
        }
    });
}

#[test]
fn pans_and_frames_are_those_of_c() {
    let mut pan = Pan::default();
    for _ in 0..4 {
        pan.follow(2.5, -0.25);
        pan.follow(f32::NAN, 1e30);
    }
    assert_eq!((pan.x(), pan.y()), (10, -1));
    assert_eq!((frame_index(3, 100), frame_stream(3, 100)), (384, 0));
    assert_eq!((frame_index(4_194_305, 1000), frame_stream(4_194_305, 1000)), (1024, 1));
}
