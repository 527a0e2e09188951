// SPDX-License-Identifier: Apache-2.0
//! Prints hashes of what paths of eight rays draw; tests/install/test_rust.py compares them with tests/c/draw_hashes.txt.

use libbn::{PathSampler, Sampler};

fn main() {
    let sampler = Sampler::new(1);
    for pixel in 0..16 {
        let (x, y) = (3 * pixel - 20, 100 - 37 * pixel);
        for index in [0, 1, 5, 255, 256, 70000] {
            let path = PathSampler::new(&sampler, x, y, index);
            let mut hash = 0u32;
            let mut add = |v: f32| hash = (hash ^ v.to_bits()).wrapping_mul(0x01000193);
            for depth in 0..8 {
                let mut ray = path.ray(depth);
                ray.draw().iter().copied().for_each(&mut add);
                (0..5).for_each(|_| add(ray.next_1d()));
                (0..3).for_each(|_| ray.next_2d().iter().copied().for_each(&mut add));
                ray.next_4d().iter().copied().for_each(&mut add);
                ray.next_loop().take(6).for_each(&mut add);
                ray.next_split(3).paths(4).for_each(|branch| add(branch.ray(1).draw()[2]));
                ray.next_split_from(9).paths(2).for_each(|branch| add(branch.ray(0).draw()[0]));
                add(ray.child(77).next_1d());
            }
            println!("{x} {y} {index} {hash:08x}");
        }
    }
}
