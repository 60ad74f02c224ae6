//! LogLuv and Pixar log against libtiff's own words and values.

mod common;

use std::fs;

use common::root;
use luxpipe::codec::logluv::cells::Cells;
use luxpipe::codec::logluv::rows::{encode_24, encode_32};
use luxpipe::codec::logluv::{Coding, Decoder, Losses, luminance_16, luminance_of, word_24, word_32};
use luxpipe::codec::pixarlog;
use luxpipe::stream::rle::Planes;

/// A row of tests/ref/logluv_vectors.csv.
struct Vector {
    label: String,
    xyz: [f32; 3],
    word_32: u32,
    colour_32: [f32; 3],
    word_24: u32,
    colour_24: [f32; 3],
}

fn vectors() -> Vec<Vector> {
    let text = fs::read_to_string(root().join("tests/ref/logluv_vectors.csv")).unwrap();
    let hex = |t: &str| u32::from_str_radix(t.trim_start_matches("0x"), 16).unwrap();
    let three = |t: &[&str]| [0, 1, 2].map(|i| t[i].parse::<f32>().unwrap());
    let row = |line: &str| {
        let t: Vec<&str> = line.split(',').collect();
        Vector {
            label: t[0].to_string(),
            xyz: three(&t[1..4]),
            word_32: hex(t[4]),
            colour_32: three(&t[5..8]),
            word_24: hex(t[8]),
            colour_24: three(&t[9..12]),
        }
    };
    text.lines().skip(1).map(row).collect()
}

fn finite(v: &&Vector) -> bool {
    v.xyz.iter().all(|x| x.is_finite())
}

fn close(got: [f32; 3], want: [f32; 3]) -> bool {
    got.iter().zip(want).all(|(a, b)| (a - b).abs() <= 4e-7 * b.abs())
}

#[test]
fn every_finite_colour_has_libtiffs_words() {
    let (mut seen, mut lost) = (0, Losses::default());
    for v in vectors().iter().filter(finite) {
        assert_eq!(word_32(v.xyz, [0.0; 3], &mut lost), v.word_32, "{} {:?}", v.label, v.xyz);
        assert_eq!(word_24(v.xyz, [0.0; 3], Cells::get(), &mut lost), v.word_24, "{} {:?}", v.label, v.xyz);
        seen += 1;
    }
    assert_eq!(seen, 250); // the other five have NaN or an infinity
    assert!(lost.over > 0 && lost.under > 0 && lost.negative > 0 && lost.chroma > 40, "{lost:?}");
}

/// Rows of many pixels take another road to the same words.
#[test]
fn rows_have_the_words_of_single_colours() {
    let vectors = vectors();
    for copies in [1, 8, 9] {
        let pixels: Vec<f32> =
            vectors.iter().filter(finite).flat_map(|v| std::iter::repeat_n(v.xyz, copies)).flatten().collect();
        let (mut planes, mut words, mut many) = (Planes::default(), Vec::new(), [Losses::default(); 2]);
        encode_32(&pixels, 1.0, &mut planes, &mut many[0]);
        encode_24(&pixels, 1.0, Cells::get(), &mut words, &mut many[1]);
        let mut single = [Losses::default(); 2];
        for (i, c) in pixels.chunks(3).enumerate() {
            let xyz = [c[0], c[1], c[2]];
            let word = word_32(xyz, [0.0; 3], &mut single[0]).to_be_bytes();
            assert_eq!(planes.each_ref().map(|p| p[i]), word, "{xyz:?}");
            let word = word_24(xyz, [0.0; 3], Cells::get(), &mut single[1]).to_be_bytes();
            assert_eq!(words[3 * i..3 * i + 3], word[1..], "{xyz:?}");
        }
        assert_eq!(many, single);
    }
}

/// Luminances at the very edges of codes, where logarithms of many and of one could differ.
#[test]
fn edges_of_codes_are_found_exactly() {
    let mut pixels = Vec::new();
    for code in (1..0x7fff).step_by(4) {
        let edge = ((f64::from(code) / 256.0) - 64.0).exp2() as f32;
        for y in [edge.next_down(), edge, edge.next_up()] {
            pixels.extend([0.95 * y, y, 1.09 * y]);
        }
    }
    // Chromaticities at the sides of the 24-bit coding's squares, and at the corners of the 32-bit one's.
    for k in 1..170 {
        let (u, v) = (0.2 + 0.0035 * f64::from(k % 40), 0.016_94 + 0.0035 * f64::from(k));
        for (u, v) in [(u, v), (f64::from(k) / 410.0, f64::from(100 + k / 2) / 410.0)] {
            let x = (9.0 * u / (4.0 * v)) as f32;
            let z = ((12.0 - 3.0 * u - 20.0 * v) / (4.0 * v)) as f32;
            pixels.extend([x.next_down(), 1.0, z, x, 1.0, z, x.next_up(), 1.0, z]);
        }
    }
    let (mut planes, mut words, mut many) = (Planes::default(), Vec::new(), [Losses::default(); 2]);
    encode_32(&pixels, 1.0, &mut planes, &mut many[0]);
    encode_24(&pixels, 1.0, Cells::get(), &mut words, &mut many[1]);
    let mut single = [Losses::default(); 2];
    for (i, c) in pixels.chunks(3).enumerate() {
        let want = word_32([c[0], c[1], c[2]], [0.0; 3], &mut single[0]).to_be_bytes();
        assert_eq!(planes.each_ref().map(|p| p[i]), want, "{c:?}");
        let want = word_24([c[0], c[1], c[2]], [0.0; 3], Cells::get(), &mut single[1]).to_be_bytes();
        assert_eq!(words[3 * i..3 * i + 3], want[1..], "{c:?}");
    }
    assert_eq!(many, single);
}

#[test]
fn words_have_libtiffs_colours() {
    let small = Decoder::new(Coding::Log24);
    let all = vectors();
    let planes: Planes = std::array::from_fn(|i| all.iter().map(|v| v.word_32.to_be_bytes()[i]).collect());
    let mut colours = vec![0.0; 3 * all.len()];
    Decoder::new(Coding::Log32).decode_32(&planes, 1.0, &mut colours);
    for (v, got) in all.iter().zip(colours.chunks(3)).filter(|(v, _)| finite(v)) {
        assert!(close([got[0], got[1], got[2]], v.colour_32), "{}: {got:?} {:?}", v.label, v.colour_32);
        let got = small.colour_24(v.word_24);
        assert!(close(got, v.colour_24), "{}: {got:?} {:?}", v.label, v.colour_24);
    }
}

/// No NaN or infinity reaches a word, whatever a processor makes of it.
#[test]
fn what_is_not_a_number_is_black() {
    for bad in [f32::NAN, -f32::NAN] {
        for at in 0..3 {
            let mut xyz = [1.0; 3];
            xyz[at] = bad;
            let mut lost = Losses::default();
            assert_eq!(word_32(xyz, [0.0; 3], &mut lost), 0x0000_56c2);
            assert_eq!(word_24(xyz, [0.0; 3], Cells::get(), &mut lost) >> 14, 0);
            let (mut planes, mut words) = (Planes::default(), Vec::new());
            encode_32(&xyz.repeat(8), 1.0, &mut planes, &mut lost);
            assert!((0..8).all(|i| planes.each_ref().map(|p| p[i]) == [0, 0, 0x56, 0xc2]));
            encode_24(&xyz.repeat(8), 1.0, Cells::get(), &mut words, &mut lost);
        }
    }
    let mut lost = Losses::default();
    assert_eq!(word_32([f32::INFINITY; 3], [0.0; 3], &mut lost) >> 16, 0x7fff);
    assert_eq!(word_32([1.0, f32::INFINITY, 1.0], [0.0; 3], &mut lost) >> 16, 0x7fff);
}

/// Every luminance code, and every cell, reads back as itself: idempotent from the second pass on.
#[test]
fn codes_read_back_as_themselves() {
    let mut lost = Losses::default();
    for code in 0..=0xffffu32 {
        // Minus nothing; and the last code but one, whose middle libtiff takes for the last one's.
        if code == 0x8000 || code & 0x7fff == 0x7ffe {
            continue;
        }
        assert_eq!(u32::from(luminance_16(luminance_of(code as u16), 0.0, &mut lost)), code);
    }
    let small = Decoder::new(Coding::Log24);
    for cell in 0..16289 {
        let word = 700 << 14 | cell;
        assert_eq!(word_24(small.colour_24(word), [0.0; 3], Cells::get(), &mut lost), word);
    }
    let planes: Planes = [
        vec![0x40; 65536],
        vec![0x80; 65536],
        (0..=65535u32).map(|i| (i >> 8) as u8).collect(),
        (0..=65535u32).map(|i| i as u8).collect(),
    ];
    let mut colours = vec![0.0; 3 * 65536];
    Decoder::new(Coding::Log32).decode_32(&planes, 1.0, &mut colours);
    let (mut again, mut lost) = (Planes::default(), Losses::default());
    encode_32(&colours, 1.0, &mut again, &mut lost);
    assert_eq!(again, planes);
    assert_eq!(lost, Losses::default());
}

#[test]
fn pixar_values_are_libtiffs() {
    let text = fs::read_to_string(root().join("tests/ref/pixarlog_table.csv")).unwrap();
    let values = pixarlog::values();
    for line in text.lines().skip(1) {
        let (code, want) = line.split_once(',').unwrap();
        let (code, want): (usize, f32) = (code.parse().unwrap(), want.parse().unwrap());
        assert!((values[code] - want).abs() <= 1e-7 * want, "{code}: {} {want}", values[code]);
        assert_eq!(usize::from(pixarlog::code(values[code])), code);
    }
    // Nearest: half way between two values the code changes.
    for k in 1..2048 {
        let middle = 0.5 * (f64::from(values[k - 1]) + f64::from(values[k]));
        assert_eq!(usize::from(pixarlog::code((middle * (1.0 - 1e-6)) as f32)), k - 1);
        assert_eq!(usize::from(pixarlog::code((middle * (1.0 + 1e-6)) as f32)), k);
    }
    assert_eq!([f32::NAN, f32::NEG_INFINITY, f32::INFINITY].map(pixarlog::code), [0, 0, 2047]);
}
