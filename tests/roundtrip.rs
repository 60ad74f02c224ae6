//! Laws of every encoding, each through the real programs there and back. The list is made of the filters themselves: a new one
//! is held to the same.

mod common;

use common::{Encoding, encodings, floats, run, split, stdout_of, stream};

const BT709: &str = "PRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";

/// What an encoding wants to be given.
#[derive(Clone, Copy, PartialEq)]
enum Takes {
    /// Colours in cd/m2.
    Light,
    /// Linear RGB of a display, 0 to 1.
    Display,
    /// Spectra; they have laws of their own in tests/radiance.rs.
    Spectra,
}

fn takes(e: &Encoding) -> Takes {
    match e.filter {
        "ra_png" => Takes::Display,
        _ if e.options.iter().any(|o| o == "--spectra") => Takes::Spectra,
        _ => Takes::Light,
    }
}

/// Encodings of colours.
fn colours() -> Vec<Encoding> {
    let all: Vec<Encoding> = encodings().into_iter().filter(|e| takes(e) != Takes::Spectra).collect();
    for name in ["ra_rgbe", "ra_rgbe --xyze", "ra_loglv", "ra_loglv --bits24", "ra_loglv --luminance", "ra_pixlog"] {
        assert!(all.iter().any(|e| e.is(name)), "{name} is not in the list");
    }
    for name in ["ra_exr", "ra_exr --float", "ra_pfm", "ra_png", "ra_png --bits 16"] {
        assert!(all.iter().any(|e| e.is(name)), "{name} is not in the list");
    }
    all
}

/// Encodings that record light.
fn masters() -> Vec<Encoding> {
    colours().into_iter().filter(|e| takes(e) == Takes::Light).collect()
}

/// RGB of BT.709, in the units that the encoding takes; `lines` are added to the header.
fn rgb(e: &Encoding, lines: &str, values: &[f32]) -> Vec<u8> {
    let units = if takes(e) == Takes::Display { "display" } else { "cd/m2" };
    let lines = if lines.is_empty() { String::new() } else { format!("\n{lines}") };
    let size = format!("-Y 1 +X {}", values.len() / 3);
    stream(&format!("NCOMP=3\nCOMPONENTS=RGB\nUNITS={units}\n{BT709}{lines}"), &size, values)
}

fn xyz(values: &[f32]) -> Vec<u8> {
    let size = format!("-Y 1 +X {}", values.len() / 3);
    stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329", &size, values)
}

/// The values that a stream holds.
fn values(stream: &[u8]) -> Vec<f32> {
    floats(split(stream).2)
}

/// Luminance of every pixel of a stream, in its units.
fn luminances(stream: &[u8]) -> Vec<f32> {
    let (lines, ..) = split(stream);
    let has = |line: &str| lines.iter().any(|l| l == line);
    if has("COMPONENTS=Y") {
        return values(stream);
    }
    let xyz = if has("COMPONENTS=XYZ") { stream.to_vec() } else { stdout_of("xyz2rgb", &["-r", "--quiet"], stream) };
    values(&xyz).chunks(3).map(|p| p[1]).collect()
}

/// Numbers from 0 to 1, always the same.
fn chance(n: u32) -> f32 {
    let mut x = n.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    x = (x ^ x >> 16).wrapping_mul(0x85eb_ca6b);
    x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    (x >> 8) as f32 / 16_777_216.0
}

/// Half of the encoding's step, as a share of a value of its range.
fn half_step(e: &Encoding) -> f32 {
    let named = |o: &str| e.options.iter().any(|p| p == o);
    match e.filter {
        // Mantissas from 128 to 255, the middle of each; the Z of D65, whose exponent Y shares, is 1.09 of Y.
        "ra_rgbe" if named("--xyze") => 1.089 / 256.0,
        "ra_rgbe" => 1.0 / 256.0,
        "ra_loglv" if named("--bits24") => 2f32.ln() / 128.0,
        "ra_loglv" => 2f32.ln() / 512.0,
        "ra_pixlog" => 0.00235, // at 1/64, a little below where its logarithm begins
        "ra_exr" if !named("--float") => 1.0 / 2048.0,
        "ra_png" => 0.02,
        _ => 1e-6,
    }
}

/// Colours of every kind in 3 decades, dark ones, and some that no encoding of light can hold.
fn every_kind(e: &Encoding) -> Vec<f32> {
    let top = if takes(e) == Takes::Display { 1.0 } else { 100.0 };
    let mut all: Vec<f32> = (0..6000).map(|i| top * 10f32.powf(-3.0 * chance(i))).collect();
    all.extend([0.0, 0.0, 0.0, top, 0.0, 0.0, 0.0, top, 0.0, 0.0, 0.0, top]);
    all.extend([-0.005 * top, 0.01 * top, 0.02 * top, 1e-9 * top, 2e-9 * top, 1e-12 * top]);
    all
}

/// What was read and written once does not change again: the second pass has the bytes of the third, and where the first pass
/// met only colours that the encoding holds, those of the first.
#[test]
fn the_second_pass_changes_nothing() {
    for e in colours() {
        let first = e.read(&e.write(&rgb(&e, "", &every_kind(&e))));
        let second = e.read(&e.write(&first));
        let third = e.read(&e.write(&second));
        let differ = values(&second).iter().zip(values(&third)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, 0, "{e}: the third pass differs from the second");
        let off = values(&first).iter().zip(values(&second)).filter(|(a, b)| **a != *b).count();
        assert_eq!(off, 0, "{e}: the second pass differs from the first");
    }
}

/// The mean of decoded over true, less one, over greys of equal odds on a logarithmic scale. For the logarithmic encodings every
/// step weighs the same so; for a shared exponent, whose steps are equal within a factor of two, whole octaves have every
/// mantissa, and equal odds within each of its steps to 1 in 128 (equal odds over mantissas would give a quarter less). The
/// greys lie evenly, so the mean is good to far less than a hundred-thousandth.
#[test]
fn decoding_has_no_bias() {
    const GREYS: usize = 400_000;
    for e in colours() {
        // Eight bits for a display have steps of 2 % and more: codes are light only to the eye.
        if e.is("ra_png") {
            continue;
        }
        // Ten octaves, so that any scale by powers of two has the same steps.
        let (top, octaves) = if takes(&e) == Takes::Display { (1.0, 4.0) } else { (1024.0, 10.0) };
        let greys: Vec<f32> =
            (0..GREYS).map(|i| (top * (-octaves * (i as f64 + 0.5) / GREYS as f64).exp2()) as f32).collect();
        let input = rgb(&e, "", &greys.iter().flat_map(|g| [*g; 3]).collect::<Vec<f32>>());
        let back = luminances(&e.read(&e.write(&input)));
        let ratios = back.iter().zip(&greys).map(|(a, b)| f64::from(*a) / f64::from(*b) - 1.0);
        let (sum, most) = ratios.fold((0.0, 0f64), |(sum, most), r| (sum + r, most.max(r.abs())));
        let bias = sum / GREYS as f64;
        assert!(bias.abs() < 1e-5, "{e}: bias {bias:.2e}");
        assert!(most < 1.02 * f64::from(half_step(&e)) + 1e-6, "{e}: {most}");
    }
}

/// NaN, infinities, negatives and what is too much: one line counts them all, and what is read is finite.
#[test]
fn what_is_no_light_is_counted_in_one_line() {
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    for e in colours() {
        for bad in [[nan, 0.1, 0.1], [0.1, inf, 0.1], [0.1, 0.1, -inf], [3e38; 3]] {
            let input = rgb(&e, "", &[&[0.5, 0.5, 0.5][..], &bad, &bad].concat());
            let said = e.remarks(&input);
            let back = values(&e.read(&e.write(&input)));
            if back == values(&input) {
                assert!(said.is_empty(), "{e} {bad:?}: {said}"); // held as it is
                continue;
            }
            assert_eq!(said.lines().count(), 1, "{e} {bad:?}: {said}");
            assert!(said.contains("2 of 3 pixels") || said.contains("of 3 pixels 2 "), "{e} {bad:?}: {said}");
            assert!(back.iter().all(|x| x.is_finite()), "{e} {bad:?}: {back:?}");
            // The light beside them is what it was.
            let grey = luminances(&e.read(&e.write(&input)))[0];
            let lost = said.contains("darker") || said.contains("under");
            assert!(lost || (grey / 0.5 - 1.0).abs() < 1.02 * half_step(&e) + 1e-5, "{e} {bad:?}: {grey}");
        }
        // A file, which may be read twice, is counted once.
        if takes(&e) == Takes::Light {
            let input = xyz(&[nan, 0.2, 0.2, inf, 0.3, 0.2]);
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), &input).unwrap();
            let options = e.options.iter().map(String::as_str).chain([file.path().to_str().unwrap(), "/dev/null"]);
            let said = run(e.filter, &options.collect::<Vec<_>>(), b"").stderr;
            assert_eq!(String::from_utf8(said).unwrap(), e.remarks(&input), "{e}");
        }
        // A picture of good light needs no word.
        let said = e.remarks(&rgb(&e, "", &[0.5, 0.4, 0.3, 0.9, 0.8, 0.7]));
        assert!(said.is_empty(), "{e}: {said}");
    }
}

/// A colour outside never comes back brighter in any component, and the word on it names what would hold it.
#[test]
fn a_colour_outside_comes_back_no_brighter() {
    const HOLDERS: [&str; 5] = ["XYZE", "float stream", "ra_loglv", "ra_exr --float", "LogLuv"];
    let mut missed = 0;
    for e in colours() {
        let (r, scale) = ([-0.5, 1.0, 2.0], if takes(&e) == Takes::Display { 0.45 } else { 1.0 });
        let outside = r.map(|x| x * scale);
        for (input, wanted) in [(rgb(&e, "", &outside), outside), (xyz(&r), r)] {
            let is_rgb = input.windows(3).any(|w| w == b"RGB");
            if !is_rgb && takes(&e) == Takes::Display {
                continue; // takes no XYZ
            }
            let back = e.read(&e.write(&input));
            let said = e.remarks(&input);
            assert!(said.lines().count() <= 1, "{e}: {said}");
            let lines = split(&back).0;
            let is = |line: &str| lines.iter().any(|l| l == line);
            if is("COMPONENTS=Y") {
                continue; // no colour at all
            }
            // In the colours of the encoding.
            let wanted = match (is_rgb, is("COMPONENTS=RGB")) {
                (true, true) | (false, false) => wanted.to_vec(),
                (true, false) => values(&stdout_of("xyz2rgb", &["-r", "--quiet"], &input)),
                (false, true) => {
                    let own = lines.iter().find_map(|l| l.strip_prefix("PRIMARIES=")).unwrap();
                    let own = own.split_whitespace().collect::<Vec<_>>().join(",");
                    values(&stdout_of("xyz2rgb", &["--quiet", "--to", &own], &input))
                }
            };
            let back = values(&back);
            let top = wanted.iter().fold(0f32, |m, x| m.max(*x));
            // Of the largest component, whose exponent all share; LogLuv's steps of u'v' are 1 in 410 and, in 24 bits, 1 in 280.
            let step = match e.to_string().as_str() {
                "ra_loglv" => 0.02 * top,
                "ra_loglv --bits24" => 0.04 * top,
                _ => 2.04 * half_step(&e) * top,
            };
            if back.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < step.max(0.004 * top)) {
                continue; // it holds it
            }
            for (a, b) in back.iter().zip(&wanted) {
                assert!(*a <= b.max(0.0) + step, "{e}: {wanted:?} came back as {back:?}");
            }
            missed += 1;
            assert!(said.contains("of 1 pixels"), "{e}: {said}");
            assert!(HOLDERS.iter().any(|h| said.contains(h)), "{e} names no encoding: {said}");
        }
    }
    assert!(missed >= 8, "{missed}");
}

/// History, Radiance's lines and what the colours mean come back from every format that has room for a text.
#[test]
fn header_lines_come_back() {
    let lines =
        "WHITE= 0.4476 0.4074\nrpict -vp 0 0 0 scene.oct\nVIEW= -vtv -vp 1 2 3 -vh 40 -vv 30\nNOBODY_KNOWS= this";
    for e in colours().iter().filter(|e| e.filter != "ra_pfm") {
        let input = rgb(e, lines, &[0.5; 12]);
        let back = e.read(&e.write(&input));
        let (got, ..) = split(&back);
        for line in lines.lines() {
            assert!(got.iter().any(|l| l == line), "{e}: {line} not in {got:?}");
        }
        let at = |line: &str| got.iter().position(|l| l == line);
        assert!(at("rpict -vp 0 0 0 scene.oct") < at(&e.to_string()), "{e}: {got:?}");
        if got.iter().any(|l| l == "COMPONENTS=RGB") {
            let own = got.iter().find_map(|l| l.strip_prefix("PRIMARIES=")).unwrap();
            let numbers = |text: &str| text.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
            assert!(numbers(own).iter().zip(&numbers(&BT709[10..])).all(near), "{e}: {own}");
        }
    }
}

/// EXPOSURE belongs to the stored numbers: it is divided out on reading, and every format then holds the light itself.
#[test]
fn exposure_is_divided_out_once() {
    let mut hdr = b"#?RADIANCE\nEXPOSURE=2\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".to_vec();
    hdr.extend([128, 128, 128, 129]); // 1.00390625, the middle of the step
    let light = 179.0 * 1.003_906_25 / 4.0;
    for e in masters() {
        let back = e.read(&e.write(&hdr));
        let got = f64::from(luminances(&back)[0]);
        assert!((got / light - 1.0).abs() < 1.02 * f64::from(half_step(&e)) + 1e-4, "{e}: {got} for {light}");
        assert!(!split(&back).0.iter().any(|l| l.starts_with("EXPOSURE")), "{e}");
    }
}

/// A grey of 100 cd/m2 is 100 in every format, by itself and beside darker light.
#[test]
fn a_hundred_candelas_are_a_hundred() {
    for e in masters() {
        for input in [rgb(&e, "", &[100.0; 3]), xyz(&[95.0456, 100.0, 108.9058, 0.5, 0.6, 0.7])] {
            let got = luminances(&e.read(&e.write(&input)))[0];
            assert!((got / 100.0 - 1.0).abs() < 1.02 * half_step(&e) + 2e-5, "{e}: {got}");
        }
    }
    // For a display the header says what white is.
    for e in colours().iter().filter(|e| takes(e) == Takes::Display) {
        let back = e.read(&e.write(&rgb(e, "DISPLAY= 0 100", &[1.0; 3])));
        assert!(split(&back).0.iter().any(|l| l == "DISPLAY= 0 100"), "{e}");
        assert!(values(&back).iter().all(|x| (x - 1.0).abs() < 1e-6), "{e}");
    }
}
