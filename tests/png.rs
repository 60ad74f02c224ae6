//! PNG both ways: what displays get, what other programs write, what damage says.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use common::{data_path, fails, floats, root, run, split, stdout_of, stream};
use luxpipe::codec::{self, Reading};
use luxpipe::color::Primaries;
use luxpipe::display::transfer::{pq_decode, srgb_decode};
use luxpipe::display::{Display, Transfer};
use luxpipe::notes::Notes;
use luxpipe::stream::meaning::Overrides;
use luxpipe::stream::reader::Input;
use luxpipe::stream::spool::Limits;
use luxpipe::stream::{Block, Header};

/// Chunks of a PNG: names and data.
fn chunks(png: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut rest = &png[8..];
    let mut list = Vec::new();
    while !rest.is_empty() {
        let n = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        list.push((String::from_utf8(rest[4..8].to_vec()).unwrap(), rest[8..8 + n].to_vec()));
        rest = &rest[12 + n..];
    }
    list
}

/// A PNG of chunks.
fn assemble(chunks: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, data) in chunks {
        let mut crc = flate2::Crc::new();
        crc.update(name.as_bytes());
        crc.update(data);
        out.extend((data.len() as u32).to_be_bytes());
        out.extend(name.as_bytes());
        out.extend(data);
        out.extend(crc.sum().to_be_bytes());
    }
    out
}

/// Samples of a PNG by the png crate, in codes.
fn codes(png: &[u8]) -> Vec<u16> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    if reader.info().bit_depth == png::BitDepth::Sixteen {
        bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect()
    } else {
        bytes.into_iter().map(u16::from).collect()
    }
}

/// A number from 0 to 1 that looks like chance.
fn chance(i: u32) -> f32 {
    let mut x = i.wrapping_mul(0x9e37_79b9);
    x = (x ^ x >> 16).wrapping_mul(0x85eb_ca6b);
    (x ^ x >> 13) as f32 / u32::MAX as f32
}

/// A display-referred stream for a display: dark and bright values, black and white among them.
fn shown(d: &Display, width: usize, height: usize) -> Vec<u8> {
    let p = d.primaries.numbers().map(|n| n.to_string()).join(" ");
    let [black, white] = d.range();
    let header = format!(
        "made by hand\nVIEW= -vtv -vh 40\nNCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nWHITE= 0.3 0.31\n\
         ADAPTED= 0.44 0.4 0.3127 0.329 cmccat2000 1\nDISPLAY= {black} {white}\nPRIMARIES= {p}"
    );
    // HLG holds no bright saturated colours.
    let most = if d.transfer == Transfer::Hlg { 0.6 } else { 1.0 };
    let mut values: Vec<f32> =
        (0..3 * width * height).map(|i| chance(i as u32).powi(1 + i as i32 % 4) * most).collect();
    values[..6].copy_from_slice(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    stream(&header, &format!("-Y {height} +X {width}"), &values)
}

/// The shipped displays, and some that none of them is.
fn displays(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> = fs::read_dir(root().join("displays"))
        .unwrap()
        .map(|e| e.unwrap().path().file_stem().unwrap().to_str().unwrap().to_string())
        .collect();
    let hdr = fs::read_to_string(root().join("displays/hdr10.toml")).unwrap();
    let crt = fs::read_to_string(root().join("displays/crt.toml")).unwrap();
    let table: Vec<String> = (0..=32).map(|i| (f64::from(i) / 32.0).powf(2.7).to_string()).collect();
    for (name, text) in [
        ("hlg", hdr.replace("\"pq\"", "\"hlg\"")),
        ("table", crt.replace("{ gamma = 2.2 }", &format!("{{ table = [{}] }}", table.join(", ")))),
        ("odd_pq", hdr.replace("\"BT.2020\"", "\"0.6,0.33,0.28,0.55,0.17,0.12,0.3457,0.3585\"")),
        ("odd_gamma", crt.replace("gamma = 2.2", "gamma = 1.8765")),
    ] {
        let path = folder.join(format!("{name}.toml"));
        fs::write(&path, text).unwrap();
        all.push(path.to_str().unwrap().to_string());
    }
    assert!(all.len() >= 9);
    all
}

/// Half a code at most lies between what was written and what is read, the header comes back, and once more changes
/// nothing.
#[test]
fn what_is_written_for_a_display_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    for name in displays(folder.path()) {
        let d: Display = name.parse().unwrap();
        let input = shown(&d, 61, 40);
        let before = floats(split(&input).2);
        for bits in ["8", "16"] {
            let write = ["--display", &name, "--bits", bits];
            let png = stdout_of("ra_png", &write, &input);
            let back = run("ra_png", &["-r"], &png);
            assert!(back.status.success() && back.stderr.is_empty(), "{name}: {back:?}");
            let (lines, resolution, pixels) = split(&back.stdout);
            assert_eq!(resolution.split_whitespace().collect::<Vec<_>>(), ["-Y", "40", "+X", "61"]);
            for line in ["made by hand", "VIEW= -vtv -vh 40", "WHITE= 0.3 0.31", "UNITS=display", "ra_png --reverse"] {
                assert!(lines.iter().any(|l| l == line), "{name}: no '{line}' in {lines:?}");
            }
            assert!(lines.iter().any(|l| l.starts_with("ra_png --display")), "{lines:?}");
            let number = |key: &str| -> Vec<f64> {
                let line = lines.iter().find_map(|l| l.strip_prefix(key)).unwrap();
                line.split_whitespace().map(|w| w.parse().unwrap()).collect()
            };
            assert_eq!(number("DISPLAY="), d.range());
            assert_eq!(number("PRIMARIES="), d.primaries.numbers());
            let after = floats(pixels);
            let y = d.primaries.to_xyz().unwrap().0[1];
            let top = if bits == "8" { 255.0 } else { 65535.0 };
            let code = |rgb: &[f32]| {
                let rgb = [0, 1, 2].map(|i| f64::from(rgb[i]).clamp(0.0, 1.0));
                d.transfer.encode(rgb, (d.black_cd_m2, d.white_cd_m2), y).map(|c| c * top)
            };
            for (a, b) in before.chunks_exact(3).zip(after.chunks_exact(3)) {
                for (a, b) in code(a).iter().zip(code(b)) {
                    assert!((a - b).abs() <= 0.5 + 0.01, "{name} {bits}: {a} {b}");
                }
            }
            let again = stdout_of("ra_png", &write, &back.stdout);
            assert!(codes(&again) == codes(&png), "{name} {bits}: changed by reading and writing");
        }
    }
}

/// Each display's file says its colours as far as readers go: who knows no cICP finds a profile, who knows neither
/// gAMA.
#[test]
fn chunks_are_those_for_the_display() {
    let folder = tempfile::tempdir().unwrap();
    let want = |name: &str| match name {
        "srgb" => "IHDR sRGB gAMA cHRM iTXt IDAT IEND",
        "p3" => "IHDR cICP iCCP gAMA cHRM iTXt IDAT IEND",
        "hdr10" | "hlg" | "odd_pq" => "IHDR cICP cHRM mDCV iTXt IDAT IEND",
        "table" => "IHDR iCCP cHRM iTXt IDAT IEND",
        _ => "IHDR iCCP gAMA cHRM iTXt IDAT IEND",
    };
    for name in displays(folder.path()) {
        let png = stdout_of("ra_png", &["--display", &name], &shown(&name.parse().unwrap(), 3, 2));
        let list = chunks(&png);
        let short = Path::new(&name).file_stem().unwrap().to_str().unwrap();
        let names: Vec<&str> = list.iter().map(|c| c.0.as_str()).collect();
        assert_eq!(names.join(" "), want(short), "{name}");
        let of = |n: &str| &list.iter().find(|c| c.0 == n).unwrap().1[..];
        match short {
            "srgb" => {
                // Values of the PNG specification, 11.3.2.5.
                let chrm = [31270u32, 32900, 64000, 33000, 30000, 60000, 15000, 6000].map(u32::to_be_bytes);
                assert_eq!((of("gAMA"), of("cHRM")), (&45455u32.to_be_bytes()[..], chrm.as_flattened()));
            }
            "p3" => assert_eq!(of("cICP"), [12, 13, 0, 1]),
            "hlg" => assert_eq!(of("cICP"), [9, 18, 0, 1]),
            "odd_pq" => assert_eq!(of("cICP"), [2, 16, 0, 1]),
            "hdr10" => {
                // BT.2020 in steps of 0.00002 and 0.0001 cd/m2, as the specification's own example has it.
                let xy = [35400u16, 14600, 8500, 39850, 6550, 2300, 15635, 16450].map(u16::to_be_bytes);
                assert_eq!((of("cICP"), &of("mDCV")[..16]), (&[9, 16, 0, 1][..], xy.as_flattened()));
                assert_eq!(of("mDCV")[16..], [10_000_000u32.to_be_bytes(), 50u32.to_be_bytes()].concat());
            }
            _ => {}
        }
    }
}

/// Lines that are not UTF-8 go as Latin-1 and come back byte for byte; a luminance that became white is the display's.
#[test]
fn any_header_line_comes_back() {
    let header = "NCOMP=3\nCOMPONENTS=RGB\nUNITS=cd/m2\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";
    let mut input = stream(header, "-Y 1 +X 1", &[10.0, 20.0, 40.0]);
    input.splice(11..11, b"caf\xe9 \xff\x80 au lait\n".iter().copied());
    let png = stdout_of("ra_png", &["--white-luminance", "50"], &input);
    assert!(chunks(&png).iter().any(|c| c.0 == "tEXt"));
    let back = stdout_of("ra_png", &["-r"], &png);
    assert!(back.windows(13).any(|w| w == b"caf\xe9 \xff\x80 au la"), "{}", String::from_utf8_lossy(&back));
    assert!(String::from_utf8_lossy(&back).contains("\nDISPLAY= 0 50\n"));
}

/// A slow ramp in 8 bits: the mean over 32 x 32 is that of the values, black and white stay what they are, nothing
/// depends on threads.
#[test]
fn dither_keeps_the_mean() {
    let (w, h) = (1024usize, 64usize);
    let header = "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";
    for (bits, top, from) in [("8", 255.0, 20.0), ("16", 65535.0, 3000.0)] {
        let code = |x: usize| from + 6.0 * x as f64 / w as f64;
        let row: Vec<f32> = (0..w).flat_map(|x| [srgb_decode(code(x) / top) as f32; 3]).collect();
        let input = stream(header, &format!("-Y {h} +X {w}"), &row.repeat(h));
        let plain = codes(&stdout_of("ra_png", &["--bits", bits], &input));
        let png = stdout_of("ra_png", &["--bits", bits, "--dither"], &input);
        assert!(png == stdout_of("ra_png", &["--bits", bits, "--dither", "--threads", "1"], &input));
        let dithered = codes(&png);
        let worst = |pixels: &[u16]| {
            let mut worst = 0f64;
            for (y0, x0, k) in (0..h / 32).flat_map(|y| (0..w / 32).flat_map(move |x| (0..3).map(move |k| (y, x, k)))) {
                let at = |i: usize| (y0 * 32 + i / 32, x0 * 32 + i % 32);
                let mean =
                    |f: &dyn Fn(usize, usize) -> f64| (0..1024).map(|i| f(at(i).0, at(i).1)).sum::<f64>() / 1024.0;
                let got = mean(&|y, x| f64::from(pixels[(y * w + x) * 3 + k]));
                worst = worst.max((got - mean(&|_, x| code(x))).abs());
            }
            worst
        };
        let (rounded, dithered) = (worst(&plain), worst(&dithered));
        assert!(rounded > 0.3 && dithered < 0.06, "{bits}: {rounded} {dithered}");
    }
    // Flat patches keep their mean, and what is a code stays that code.
    for value in [0.1, 0.25, 0.5, 0.77, 0.95] {
        let light = srgb_decode((100.0 + value) / 255.0) as f32;
        let pixels = codes(&stdout_of("ra_png", &["--dither"], &stream(header, "-Y 40 +X 50", &vec![light; 6000])));
        let mean = pixels.iter().map(|c| f64::from(*c)).sum::<f64>() / 6000.0;
        assert!((mean - 100.0 - value).abs() < 0.05, "{value}: {mean}");
    }
    let exact: Vec<f32> = (0..=255).flat_map(|c| [srgb_decode(f64::from(c) / 255.0) as f32; 3]).collect();
    let pixels = codes(&stdout_of("ra_png", &["--dither"], &stream(header, "-Y 1 +X 256", &exact)));
    assert!(pixels.chunks_exact(3).enumerate().all(|(i, c)| c == [i as u16; 3]), "{pixels:?}");
}

/// Rows of a file decoded here.
fn read(path: &Path) -> luxpipe::Result<(Header, Vec<f32>, Vec<String>)> {
    let limits = Limits { memory: 1 << 20, folder: std::env::temp_dir() };
    let (overrides, notes) = (Overrides::default(), Notes::default());
    let reading = Reading { overrides: &overrides, limits: &limits, notes: &notes };
    let mut picture = codec::open(Input::open(Some(path))?, &reading)?;
    let (mut block, mut all) = (Block::default(), Vec::new());
    while picture.next(&mut block)? {
        all.extend_from_slice(&block.data);
    }
    // A file is read again from its beginning, and is the same.
    assert!(picture.rewind()?);
    let mut again = Vec::new();
    while picture.next(&mut block)? {
        again.extend_from_slice(&block.data);
    }
    assert!(all.iter().map(|x| x.to_bits()).eq(again.iter().map(|x| x.to_bits())));
    Ok((picture.header().clone(), all, notes.take()))
}

fn foreign(name: &str) -> (Header, Vec<f32>, String) {
    let path = data_path(&format!("png/{name}.png"));
    let (header, pixels, notes) = read(Path::new(&path)).unwrap();
    // A pipe is read as a file is.
    let piped = stdout_of("ra_png", &["-r"], &fs::read(&path).unwrap());
    assert!(floats(split(&piped).2) == pixels, "{name}");
    (header, pixels, notes.join("\n"))
}

fn near(got: &[f32], want: impl Iterator<Item = f64>, name: &str) {
    let want: Vec<f64> = want.collect();
    assert_eq!(got.len(), want.len(), "{name}");
    for (i, (a, b)) in got.iter().zip(want).enumerate() {
        assert!((f64::from(*a) - b).abs() <= 1e-6 + 1e-6 * b.abs(), "{name}: number {i} is {a}, not {b}");
    }
}

/// Files of Pillow and libpng; tests/ref/png_files.py says what is in them.
#[test]
fn files_of_other_programs_are_read() {
    let (header, pixels, notes) = foreign("palette");
    assert_eq!((header.resolution.width, header.resolution.height), (5, 3));
    let palette = [[255, 0, 0], [0, 128, 0], [0, 0, 255], [200, 100, 50], [10, 20, 30]];
    near(&pixels, (0..15).flat_map(|i| palette[i % 5]).map(|c| srgb_decode(f64::from(c) / 255.0)), "palette");
    assert!(notes.contains("transparency is ignored") && notes.contains("taking sRGB"), "{notes}");
    let (header, pixels, notes) = foreign("grey16");
    near(&pixels, (0..12).flat_map(|i| [srgb_decode(f64::from(i * 5957) / 65535.0); 3]), "grey16");
    assert!(header.primaries == Some(Primaries::BT709) && !notes.contains("transparency"), "{notes}");
    let (_, pixels, _) = foreign("grey1");
    near(&pixels, (0..36).flat_map(|i| [f64::from((i / 9 + i % 9) % 2); 3]), "grey1");
    let (header, pixels, notes) = foreign("interlaced");
    let adobe: Primaries = "0.64,0.33,0.21,0.71,0.15,0.06,0.3127,0.329".parse().unwrap();
    assert!(header.primaries.unwrap().distance(&adobe) < 1e-5 && notes.is_empty(), "{notes}");
    let code = |i: usize| (37 * (i / 3 % 13) + 59 * (i / 39) + 83 * (i % 3)) % 256;
    near(&pixels, (0..3 * 117).map(|i| (code(i) as f64 / 255.0).powf(1e5 / 55556.0)), "interlaced");
    // 1 MB is what `read` allows; the picture has less.
    let out = run("ra_png", &["-r", "--memory", "100", &data_path("png/interlaced.png")], b"");
    assert!(String::from_utf8_lossy(&out.stderr).contains("--memory"));
}

/// Profiles that LittleCMS wrote, of version 4 and 2; its own Lab of the colours, printed by tests/ref/png_files.py.
#[test]
fn profiles_of_littlecms_are_understood() {
    let adobe = Primaries { rgb: "Adobe".parse::<Primaries>().unwrap().rgb, ..Primaries::BT709 };
    let p3: Primaries = "P3".parse().unwrap();
    let labs_p3 = [
        [100.0, 0.0, 0.0],
        [56.207, 94.473, 98.897],
        [86.615, -106.545, 102.863],
        [31.014, 70.447, -115.586],
        [53.586, 0.0, 0.0],
        [48.747, 72.891, -1.168],
        [0.5, -0.232, -0.532],
    ];
    let labs_adobe = [
        [100.0, 0.0, 0.0],
        [62.601, 90.371, 78.149],
        [83.214, -129.09, 87.173],
        [30.21, 69.244, -113.611],
        [60.766, 0.0, 0.0],
        [57.16, 70.632, -0.216],
        [0.126, -0.084, -0.283],
    ];
    for (name, primaries, labs) in [("p3_icc", p3, labs_p3), ("adobe_icc2", adobe, labs_adobe)] {
        let (header, pixels, notes) = foreign(name);
        let p = header.primaries.unwrap();
        assert!(p.distance(&primaries) < 1e-3 && notes.is_empty(), "{name}: {p} {notes}");
        // Bradford to D50 by its published matrix from D65 (Lindbloom).
        let bradford = [
            [1.0478112, 0.0228866, -0.0501270],
            [0.0295424, 0.9904844, -0.0170491],
            [-0.0092345, 0.0150436, 0.7521316],
        ];
        for (rgb, want) in pixels.chunks_exact(3).zip(labs) {
            let xyz = p.to_xyz().unwrap().apply([0, 1, 2].map(|i| f64::from(rgb[i])));
            let lab = lab_d50(luxpipe::color::Mat3(bradford).apply(xyz));
            assert!(lab.iter().zip(want).all(|(a, b)| (a - b).abs() < 0.1), "{name}: {lab:?} {want:?}");
        }
    }
}

fn lab_d50(xyz: [f64; 3]) -> [f64; 3] {
    let f = |t: f64| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let [x, y, z] = [f(xyz[0] / 0.9642), f(xyz[1]), f(xyz[2] / 0.8249)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// What the chunks say, in their order of rank; what is not understood is told.
#[test]
fn colours_are_said_by_the_first_chunk_that_is_understood() {
    let pixels = b"\x00\x80\x80\x80";
    let idat = ("IDAT".to_string(), zlib(pixels));
    let ihdr = ("IHDR".to_string(), [&[0, 0, 0, 1, 0, 0, 0, 1][..], &[8, 2, 0, 0, 0]].concat());
    let chunk = |name: &str, data: &[u8]| (name.to_string(), data.to_vec());
    let gama = chunk("gAMA", &100_000u32.to_be_bytes());
    let srgb = chunk("sRGB", &[0]);
    let cicp = |a: u8, b: u8| chunk("cICP", &[a, b, 0, 1]);
    let bad_icc = chunk("iCCP", &[b"x\0\0".to_vec(), zlib(&[7; 200])].concat());
    let value = |list: &[(String, Vec<u8>)], args: &[&str]| {
        let mut all = vec![ihdr.clone()];
        all.extend_from_slice(list);
        all.extend([idat.clone(), chunk("IEND", &[])]);
        let out = run("ra_png", &[&["-r"], args].concat(), &assemble(&all));
        assert!(out.status.success(), "{out:?}");
        let (lines, _, pixels) = split(&out.stdout);
        let line = lines.into_iter().find(|l| l.starts_with("PRIMARIES=")).unwrap();
        (f64::from(floats(pixels)[0]), line, String::from_utf8(out.stderr).unwrap())
    };
    let half = 128.0 / 255.0;
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    close(value(&[], &[]).0, srgb_decode(half));
    let (v, p, note) = value(&[], &["--primaries", "P3"]);
    close(v, srgb_decode(half));
    assert!(p.contains("0.68 0.32") && note.contains("its curve"), "{p} {note}");
    close(value(std::slice::from_ref(&gama), &[]).0, half);
    close(value(&[gama.clone(), srgb.clone()], &[]).0, srgb_decode(half));
    let (v, _, note) = value(&[bad_icc.clone(), gama.clone()], &[]);
    close(v, half);
    assert!(note.contains("ICC profile is none"), "{note}");
    close(value(&[cicp(9, 8), srgb.clone()], &[]).0, half);
    assert!(value(&[cicp(9, 8)], &[]).1.contains("0.708 0.292"));
    let (v, _, note) = value(&[cicp(9, 16)], &[]);
    close(v, pq_decode(half) / 1e4);
    assert!(note.contains("10000 cd/m2"), "{note}");
    let (v, _, note) = value(&[cicp(1, 1)], &[]);
    close(v, half.powf(2.4));
    assert!(note.contains("2.4"), "{note}");
    let (v, _, note) = value(&[cicp(2, 2), srgb.clone()], &[]);
    close(v, srgb_decode(half));
    assert!(note.contains("2/2"), "{note}");
    // HLG: grey 0.5 is scene light 1/12 on a display of gamma 1.2.
    let (v, _, _) = value(&[cicp(9, 18)], &[]);
    close(v, luxpipe::display::transfer::hlg_decode(half).powf(1.2));
    let narrow = assemble(&[ihdr.clone(), chunk("cICP", &[9, 16, 0, 0]), idat.clone(), chunk("IEND", &[])]);
    fails("ra_png", &["-r"], &narrow, 1, "narrow");
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut z = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut z, data).unwrap();
    z.finish().unwrap()
}

/// Small files of each kind: 8 and 16 bits, with a profile, interlaced.
fn small(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for (name, bits) in [("srgb", "8"), ("crt", "8"), ("hdr10", "16")] {
        let d: Display = name.parse().unwrap();
        all.push((name.to_string(), stdout_of("ra_png", &["--display", name, "--bits", bits], &shown(&d, 7, 5))));
    }
    for name in ["interlaced", "palette", "adobe_icc2"] {
        all.push((name.to_string(), fs::read(data_path(&format!("png/{name}.png"))).unwrap()));
    }
    fs::create_dir_all(folder).unwrap();
    all
}

fn read_bytes(bytes: &[u8], folder: &Path) -> luxpipe::Result<(Header, Vec<f32>, Vec<String>)> {
    let path: PathBuf = folder.join("try.png");
    fs::write(&path, bytes).unwrap();
    read(&path)
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    for (name, png) in small(folder.path()) {
        assert!(read_bytes(&png, folder.path()).is_ok(), "{name}");
        for end in 0..png.len() {
            let error = read_bytes(&png[..end], folder.path()).expect_err(&format!("{name} cut at {end}")).to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }
    let png = &small(folder.path())[0].1;
    let idat = png.windows(4).position(|w| w == b"IDAT").unwrap();
    fails("ra_png", &["-r"], &png[..idat + 20], 1, "picture ends at row 1 of 5");
    fails("ra_png", &["-r"], &png[..png.len() - 12], 1, "IEND");
    fails("picinfo", &[], &png[..30], 1, "before its first row");
    let mut wrong = png.clone();
    wrong[idat + 30] ^= 1;
    fails("vonkries", &["--to", "D65"], &wrong, 1, "row");
    let mut wrong = png.clone();
    let gama = png.windows(4).position(|w| w == b"gAMA").unwrap();
    wrong[gama + 5] ^= 1;
    fails("ra_png", &["-r"], &wrong, 1, "CRC");
    let noted = run("ra_png", &["-r"], &[&png[..], b"junk"].concat());
    assert!(String::from_utf8_lossy(&noted.stderr).contains("bytes after the IEND"), "{noted:?}");
    assert!(noted.stdout == stdout_of("ra_png", &["-r"], png));
}

/// Damage with checksums that fit, and any other: an error or a picture, in little time.
#[test]
fn damage_neither_panics_nor_hangs() {
    let folder = tempfile::tempdir().unwrap();
    let begun = Instant::now();
    let all = small(folder.path());
    for seed in 0..3000u32 {
        let png = &all[seed as usize % all.len()].1;
        let pick = |k: u32, n: usize| (f64::from(chance(seed * 16 + k)) * (n as f64 - 1e-9)) as usize % n;
        let mut bytes = png.clone();
        if seed % 2 == 0 {
            for k in 0..1 + seed % 5 {
                let at = pick(2 * k, bytes.len());
                bytes[at] = pick(2 * k + 1, 256) as u8;
            }
        } else {
            let mut list = chunks(&bytes);
            let which = pick(0, list.len());
            let data = &mut list[which].1;
            if data.is_empty() || seed % 7 == 0 {
                data.extend([1, 2, 3]);
            } else {
                let at = pick(1, data.len());
                data[at] = pick(2, 256) as u8;
                // A height may grow to where only the end of the file ends it, never beyond.
                let cut = pick(3, 4 * data.len());
                data.truncate(cut.max(1));
            }
            if seed % 5 == 0 {
                let other = pick(4, list.len());
                list.swap(which, other);
            }
            bytes = assemble(&list);
        }
        if let Ok((header, pixels, _)) = read_bytes(&bytes, folder.path()) {
            let r = header.resolution;
            assert!(pixels.len() == 3 * r.width * r.height && pixels.iter().all(|x| x.is_finite()), "{seed}");
        }
    }
    assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
}

/// Sizes, profiles and texts that claim or unpack to more than is there.
#[test]
fn what_would_fill_memory_is_refused() {
    let chunk = |name: &str, data: &[u8]| (name.to_string(), data.to_vec());
    let ihdr = |w: u32, h: u32, interlaced: u8| {
        chunk("IHDR", &[&w.to_be_bytes()[..], &h.to_be_bytes(), &[16, 6, 0, 0, interlaced]].concat())
    };
    let (idat, iend) = (chunk("IDAT", &zlib(&[0; 9])), chunk("IEND", &[]));
    let png = |list: &[&(String, Vec<u8>)]| assemble(&list.iter().map(|c| (*c).clone()).collect::<Vec<_>>());
    let tall = png(&[&ihdr(1, i32::MAX as u32, 0), &idat, &iend]);
    fails("ra_png", &["-r"], &tall, 1, "row 2");
    fails("ra_png", &["-r"], &png(&[&ihdr(i32::MAX as u32, 1, 0), &idat, &iend]), 1, "at most 16777216");
    fails("ra_png", &["-r"], &png(&[&ihdr(1, u32::MAX, 0), &idat, &iend]), 1, "at most 2147483647");
    fails("ra_png", &["-r"], &png(&[&ihdr(1 << 20, 1 << 20, 1), &idat, &iend]), 1, "--memory");
    let zeros = vec![0; 100 << 20];
    let bomb = zlib(&zeros);
    let one = chunk("IDAT", &zlib(&[0; 9]));
    let with = |c: (String, Vec<u8>)| png(&[&ihdr(1, 1, 0), &c, &one, &iend]);
    // A profile that does not fit is as good as none.
    let out = run("ra_png", &["-r"], &with(chunk("iCCP", &[b"x\0\0".to_vec(), bomb.clone()].concat())));
    assert!(out.status.success() && String::from_utf8_lossy(&out.stderr).contains("taking sRGB"), "{out:?}");
    fails("ra_png", &["-r"], &with(chunk("zTXt", &[b"luxpipe\0\0".to_vec(), bomb.clone()].concat())), 1, "text");
    fails("ra_png", &["-r"], &with(chunk("iTXt", &[b"luxpipe\0\x01\0\0\0".to_vec(), bomb].concat())), 1, "text");
    fails("ra_png", &["-r"], &with(chunk("tEXt", &[b"luxpipe\0".to_vec(), vec![b'x'; 2 << 20]].concat())), 1, "text");
    fails("ra_png", &["-r"], &with(chunk("eXIf", &zeros)), 1, "metadata");
}

/// Light that HLG cannot hold at a white is counted: pure red at full light is more than its brightest red.
#[test]
fn what_hlg_cannot_hold_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let hlg = displays(folder.path()).into_iter().find(|n| n.ends_with("hlg.toml")).unwrap();
    let header = "NCOMP=3\nCOMPONENTS=RGB\nUNITS=display\nPRIMARIES= .708 .292 .17 .797 .131 .046 .3127 .329";
    // Code (1, 0, 0) is 0.2627 ^ 0.2 = 0.7654 of white's red, by BT.2100.
    for (red, told) in [(0.76, false), (0.77, true)] {
        let out = run("ra_png", &["--display", &hlg], &stream(header, "-Y 1 +X 1", &[red, 0.0, 0.0]));
        assert_eq!(String::from_utf8_lossy(&out.stderr).contains("1 of 1 pixels are of colours"), told, "{out:?}");
    }
}
