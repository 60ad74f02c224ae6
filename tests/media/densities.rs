//! Densities: what lies along a way is the integral of what lies at its places, and is reached where it says.

use std::sync::Arc;

use glam::{DVec3, Vec3A};
use luxpipe::medium::density::exponential::Exponential;
use luxpipe::medium::density::grid::Grid;
use luxpipe::medium::density::homogeneous::Homogeneous;
use luxpipe::medium::density::vol::{self, Volume};
use luxpipe::medium::density::{Density, Way};
use luxpipe::render::sampler::Sampler;

/// A grid of 20 x 11 x 9 voxels, most of them empty.
fn grid(null: bool) -> Grid {
    let size = [20, 11, 9];
    let values = (0..size.iter().product::<usize>())
        .map(|i| {
            let s = Sampler::new(i as u32, 3, 0, 1).pair(0);
            // Empty in its middle third, so that blocks are.
            if (7..15).contains(&(i % 20)) || s[0] < 0.5 { 0.0 } else { s[1] }
        })
        .collect();
    let volume = Volume { size, low: [0.0; 3], high: [1.0; 3], values };
    Grid::new(&volume, DVec3::new(-1.0, -0.4, 0.1), DVec3::new(1.0, 0.7, 0.9), 2.0, null)
}

fn all() -> Vec<(&'static str, Arc<dyn Density>)> {
    vec![
        ("homogeneous", Arc::new(Homogeneous { density: 0.7 })),
        ("exponential", Arc::new(Exponential::new(DVec3::new(0.0, 0.0, 0.2), DVec3::new(0.1, 0.0, 1.0), 0.4))),
        ("grid", Arc::new(grid(false))),
    ]
}

fn ways() -> Vec<Way> {
    let mut ways = Vec::new();
    for i in 0..60 {
        let s = Sampler::new(i, 9, 0, 1);
        let [[a, b], [c, d], [e, f]] = [s.pair(0), s.pair(1), s.pair(2)];
        let origin = Vec3A::new(3.0 * a - 1.5, 3.0 * b - 1.5, 3.0 * c - 1.5);
        // Some along an axis, some level for the exponential.
        let direction = match i % 6 {
            0 => Vec3A::Y,
            1 => -Vec3A::X,
            _ => Vec3A::new(d - 0.5, e - 0.5, f - 0.5).normalize(),
        };
        ways.push(Way { origin, direction, length: 0.1 + 3.0 * d });
    }
    ways
}

#[test]
fn integrals_along_ways_are_those_of_places() {
    for (name, density) in all() {
        for way in ways() {
            let n = 40_000;
            let at = |i: u32| f64::from(density.at(way.at(way.length * (i as f32 + 0.5) / n as f32)));
            let want = (0..n).map(at).sum::<f64>() / f64::from(n) * f64::from(way.length);
            let got = f64::from(density.along(&way));
            assert!((got - want).abs() < 2e-4 * want + 2e-5, "{name}: {got} for {want} along {way:?}");
        }
    }
}

#[test]
fn what_is_along_is_reached() {
    for (name, density) in all() {
        for way in ways() {
            let all = density.along(&way);
            for share in [0.01f32, 0.3, 0.9] {
                if all < 1e-3 {
                    continue;
                }
                let Some(t) = density.reach(&way, share * all) else {
                    panic!("{name}: {share} of {all} is not reached")
                };
                let up_to = density.along(&way.up_to(t));
                assert!((up_to - share * all).abs() < 1e-4 * all, "{name}: {up_to} for {}", share * all);
            }
            assert!(density.reach(&way, 1.01 * all + 1e-6).is_none(), "{name}: beyond the end");
        }
    }
}

/// Where they end is no end of their air: the same frame, the same density.
#[test]
fn frames_do_not_change_a_density() {
    for (name, density) in all() {
        let (centre, scale) = (DVec3::new(5.0, -3.0, 2.0), 0.25);
        let moved = density.within(centre, scale);
        for way in ways() {
            let origin = ((way.origin.as_dvec3() - centre) * scale).as_vec3a();
            let there = Way { origin, length: way.length * scale as f32, ..way };
            let (a, b) = (density.along(&way), moved.along(&there) / scale as f32);
            assert!((a - b).abs() < 2e-3 * a + 1e-3, "{name}: {a} {b}");
        }
    }
}

/// Null collisions find what regular tracking does: chances to come through agree within the noise.
#[test]
fn null_collisions_let_as_much_through() {
    let density = grid(true);
    for (n, way) in ways().into_iter().enumerate() {
        let all = density.along(&way);
        let (mut through, tries) = (0u32, 4000);
        for i in 0..tries {
            let mut k = 0;
            let mut lot = || {
                k += 1;
                Sampler::new(i, n as u32, 0, 77).pair(k)
            };
            let mut from = 0.0;
            let mut free = true;
            loop {
                let [a, b] = lot();
                let Some(c) = density.candidate(&way, from, -(1.0 - a).ln()) else { break };
                from = c.t;
                if b < c.share {
                    free = false;
                    break;
                }
            }
            through += u32::from(free);
        }
        let (got, want) = (f64::from(through) / f64::from(tries), f64::from((-all).exp()));
        let error = (want * (1.0 - want) / f64::from(tries)).sqrt();
        assert!((got - want).abs() <= 4.5 * error + 1e-3, "{got} for {want}");
    }
}

/// Zero density takes nothing away, and no way ends in it.
#[test]
fn empty_space_is_clear() {
    let none = Homogeneous { density: 0.0 };
    let way = Way { origin: Vec3A::ZERO, direction: Vec3A::X, length: f32::INFINITY };
    assert_eq!((none.along(&way), none.reach(&way, 1.0)), (0.0, None));
    let grid = grid(false);
    let aside = Way { origin: Vec3A::new(0.0, 0.0, 5.0), ..way };
    assert_eq!((grid.along(&aside), grid.reach(&aside, 1e-9)), (0.0, None));
}

/// Bytes of a volume file of 3 x 2 x 2 voxels.
fn bytes() -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    [1i32, 3, 2, 2, 1].iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    [0f32, 0.0, 0.0, 3.0, 2.0, 2.0].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    (0..12).for_each(|i| bytes.extend((i as f32).to_le_bytes()));
    bytes
}

/// Files that end early, claim too much, or hold what is no density are refused with a reason; no bytes are too odd.
#[test]
fn damaged_volumes_are_refused() {
    let good = bytes();
    let parse = |bytes: &[u8]| vol::parse(&mut &bytes[..]);
    let volume = parse(&good).unwrap();
    assert_eq!((volume.size, volume.high, volume.values[11]), ([3, 2, 2], [3.0, 2.0, 2.0], 11.0));
    for end in 0..good.len() {
        assert!(parse(&good[..end]).is_err(), "ends after {end} bytes");
    }
    let with = |at: usize, word: [u8; 4]| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&word);
        parse(&bytes).map(|_| ()).unwrap_err().to_string()
    };
    assert!(with(0, *b"VOX\x03").contains("no volume"));
    assert!(with(4, 3i32.to_le_bytes()).contains("encoding 3"));
    assert!(with(20, 3i32.to_le_bytes()).contains("3 channels"));
    assert!(with(8, (-3i32).to_le_bytes()).contains("voxels"));
    assert!(with(8, i32::MAX.to_le_bytes()).contains("voxels"));
    assert!(with(8, 1_000_000i32.to_le_bytes()).contains("ends in row"));
    assert!(with(52, (-1f32).to_le_bytes()).contains("voxel 1 is -1"));
    assert!(with(48, f32::NAN.to_le_bytes()).contains("voxel 0 is NaN"));
    for i in 0..4000u32 {
        let mut bytes = good.clone();
        let [a, b] = Sampler::new(i, 4, 0, 1).pair(0);
        let at = (a * bytes.len() as f32) as usize;
        bytes[at] ^= 1 << (b * 8.0) as u8;
        let _ = parse(&bytes);
    }
}
