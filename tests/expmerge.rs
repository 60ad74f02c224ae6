//! expmerge through the real program. Scenes and responses are closed forms below; figures of the case debevec-synthetic-bracket are
//! from tests/ref/README.md.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{data_path, fails, floats, run, split, stdout_of};
use luxpipe::color::{Mat3, Primaries, Xy};

/// A response: code 0 to 1 of light 0 to 1.
type Curve = fn(f64) -> f64;

fn gamma(x: f64) -> f64 {
    x.powf(1.0 / 2.2)
}

fn srgb(x: f64) -> f64 {
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// An S as film has it: a toe and a shoulder over a gamma.
fn film(x: f64) -> f64 {
    let y = x.powf(1.0 / 2.4);
    0.5 * y * y * (3.0 - 2.0 * y) + 0.5 * y
}

/// The case's exposures.
const TIMES: [f64; 7] = [1e-3, 1.0 / 250.0, 1.0 / 60.0, 1.0 / 15.0, 0.25, 1.0, 4.0];
const TIMES_TEXT: &str = "1/1000,1/250,1/60,1/15,1/4,1,4";

/// Numbers of a normal distribution, the same every time.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// A scene of `width` pixels across, and how it is photographed.
struct Shoot<'a> {
    light: &'a [[f64; 3]],
    width: usize,
    curve: Curve,
    /// Of a full code, at black; and of light, as photons have it.
    noise: (f64, f64),
    sixteen: bool,
}

impl<'a> Shoot<'a> {
    fn of(light: &'a [[f64; 3]], width: usize, curve: Curve) -> Shoot<'a> {
        Shoot { light, width, curve, noise: (0.0, 0.0), sixteen: false }
    }

    /// Codes at an amount of exposure.
    fn codes(&self, amount: f64, noise: &mut Noise) -> Vec<u16> {
        let full = if self.sixteen { 65535.0 } else { 255.0 };
        let (read, shot) = self.noise;
        let mut code = |e: &f64| {
            let x = e * amount;
            let x = x + noise.normal() * shot * x.max(0.0).sqrt();
            let z = (self.curve)(x.clamp(0.0, 1.0)) + noise.normal() * read;
            (z.clamp(0.0, 1.0) * full).round() as u16
        };
        self.light.iter().flatten().map(&mut code).collect()
    }

    /// A PNG file an exposure.
    fn bracket(&self, folder: &Path, amounts: &[f64]) -> Vec<String> {
        let mut noise = Noise(1);
        let file = |(i, amount): (usize, &f64)| {
            let path = folder.join(format!("{i}.png"));
            png(&path, self.width, &self.codes(*amount, &mut noise), self.sixteen);
            text(&path)
        };
        amounts.iter().enumerate().map(file).collect()
    }
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_string()
}

fn png(path: &Path, width: usize, codes: &[u16], sixteen: bool) {
    let file = fs::File::create(path).unwrap();
    let mut encoder = png::Encoder::new(file, width as u32, (codes.len() / 3 / width) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(if sixteen { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    let bytes: Vec<u8> = match sixteen {
        true => codes.iter().flat_map(|c| c.to_be_bytes()).collect(),
        false => codes.iter().map(|c| *c as u8).collect(),
    };
    encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
}

fn words<'a>(options: &[&'a str], files: &'a [String]) -> Vec<&'a str> {
    options.iter().copied().chain(files.iter().map(String::as_str)).collect()
}

/// Pixels that expmerge makes, notes aside.
fn merged(options: &[&str], files: &[String]) -> Vec<[f32; 3]> {
    let out = stdout_of("expmerge", &words(options, files), b"");
    floats(split(&out).2).as_chunks::<3>().0.to_vec()
}

/// rms and largest of ln E against the truth, up to one constant, over a channel.
fn errors(got: &[[f32; 3]], want: &[[f64; 3]], channel: usize) -> (f64, f64) {
    let off: Vec<f64> = got.iter().zip(want).map(|(a, b)| (f64::from(a[channel]) / b[channel]).ln()).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let rms = (off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt();
    (rms, off.iter().fold(0.0, |m: f64, d| m.max((d - mean).abs())))
}

/// 2000 grey pixels over 4.4 decades.
fn decades() -> Vec<[f64; 3]> {
    (0..2000).map(|i| [10f64.powf(-2.2 + 4.4 * f64::from(i) / 1999.0); 3]).collect()
}

/// The case debevec-synthetic-bracket (tests/ref/README.md): ln E to an rms of 0.01, g to its own tolerance of 0.05.
#[test]
fn the_case_of_debevec() {
    const Z: [usize; 11] = [8, 16, 32, 64, 96, 128, 160, 192, 224, 240, 248];
    const GAMMA: [f64; 11] =
        [-6.0997, -4.57477, -3.04985, -1.52492, -0.632901, 0.0, 0.490916, 0.892023, 1.23115, 1.38294, 1.45508];
    const SRGB: [f64; 11] =
        [-4.48748, -3.72953, -2.70436, -1.43754, -0.612709, 0.0, 0.48767, 0.892787, 1.23929, 1.39543, 1.46985];
    let folder = tempfile::tempdir().unwrap();
    let scene = decades();
    for (name, curve, g) in [("gamma", gamma as Curve, GAMMA), ("srgb", srgb, SRGB)] {
        let files = Shoot::of(&scene, 50, curve).bracket(folder.path(), &TIMES);
        let (rms, most) = errors(&merged(&["--times", TIMES_TEXT], &files), &scene, 1);
        println!("{name}: rms of ln E {rms:.5}, largest {most:.4}");
        assert!(rms <= 0.01 && most < 0.05, "{name}: {rms} {most}");
        let printed = stdout_of("expmerge", &words(&["--times", TIMES_TEXT, "--response"], &files), b"");
        let printed = String::from_utf8(printed).unwrap();
        let lines: Vec<Vec<f64>> = printed
            .lines()
            .filter(|l| !l.starts_with('#'))
            .map(|l| l.split('\t').map(|n| n.parse().unwrap()).collect())
            .collect();
        assert_eq!(lines.len(), 256);
        for (z, want) in Z.iter().zip(g) {
            for got in &lines[*z][1..4] {
                assert!((got - want).abs() < 0.05, "{name}: g({z}) = {got}, not {want}");
            }
        }
        assert_eq!(lines[128][1..], [0.0; 3]);
    }
}

/// Noise of half a code and of photons, three colours, an S-shaped curve, 8 and 16 bits: what a recovered curve costs is little beside
/// what the noise does.
#[test]
fn noise_costs_more_than_recovery() {
    let folder = tempfile::tempdir().unwrap();
    let mut draw = Noise(7);
    let scene: Vec<[f64; 3]> = (0..120 * 80)
        .map(|i| {
            let e = 10f64.powf(-1.0 + 3.0 * f64::from(i % 120) / 119.0);
            [1.0, 0.5 + 0.5 * draw.uniform(), 0.3 + 0.7 * f64::from(i / 120) / 79.0].map(|c| c * e)
        })
        .collect();
    // What --response would print of the film if it knew.
    let table: String = (0..256)
        .map(|z| {
            let (mut low, mut high) = (-40.0f64, 0.0f64);
            for _ in 0..80 {
                let mid = 0.5 * (low + high);
                if film(mid.exp()) < f64::from(z) / 255.0 { low = mid } else { high = mid }
            }
            format!("{z} {low}\n")
        })
        .collect();
    let known = folder.path().join("film.txt");
    fs::write(&known, table).unwrap();
    let known = text(&known);
    for sixteen in [false, true] {
        let shoot = Shoot { noise: (0.002, 0.004), sixteen, ..Shoot::of(&scene, 120, film) };
        let files = shoot.bracket(folder.path(), &TIMES);
        let recovered = merged(&["--times", TIMES_TEXT], &files);
        let best = merged(&["--times", TIMES_TEXT, "--curve", &known], &files);
        for channel in 0..3 {
            let (a, b) = (errors(&recovered, &scene, channel).0, errors(&best, &scene, channel).0);
            println!("16 bits {sixteen}, channel {channel}: rms of ln E {a:.5}, with the curve known {b:.5}");
            assert!(a < 0.02 && a < 1.3 * b + 0.002, "{sixteen} {channel}: {a} {b}");
        }
    }
}

/// Two brackets of one scene, other times, apertures and speeds: one scale, by recovered curves within 2 %, by one curve within
/// rounding.
#[test]
fn sets_have_one_scale() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("a"), folder.path().join("b"));
    fs::create_dir(&first).unwrap();
    fs::create_dir(&second).unwrap();
    let scene: Vec<[f64; 3]> = decades()[500..1500].to_vec();
    let shoot = Shoot::of(&scene, 50, srgb);
    // t S / N^2 against 100 / 4^2, as seconds: what the sensor gets is the same for the same amount.
    let a = shoot.bracket(&first, &[0.01, 0.05, 0.25, 1.25]);
    let b = shoot.bracket(&second, &[0.02, 0.08, 0.5, 2.0]);
    let set_a = ["--times", "0.01,0.05,0.25,1.25", "--iso", "100", "--aperture", "4"];
    let set_b = ["--times", "0.02,0.08,0.5,2", "--iso", "400", "--aperture", "8"];
    let ratio = |extra: &[&str]| {
        let x = merged(&[&set_a[..], extra].concat(), &a);
        let y = merged(&[&set_b[..], extra].concat(), &b);
        let logs = x.iter().zip(&y).map(|(p, q)| f64::from(p[1] / q[1]).ln());
        (logs.sum::<f64>() / x.len() as f64).exp()
    };
    let (own, shared) = (ratio(&[]), ratio(&["--curve", "srgb"]));
    println!("scale of one set over the other: {own:.4} recovered, {shared:.4} with one curve");
    assert!((own - 1.0).abs() < 0.02 && (shared - 1.0).abs() < 0.003, "{own} {shared}");
    // And that scale is ISO 12232's: x N^2 / (t S) of 10 / (0.65 x 0.18) cd/m2.
    let light = merged(&[&set_a[..], &["--curve", "srgb"]].concat(), &a);
    let want = scene[500][1] * 10.0 / (0.65 * 0.18) * 16.0 / 100.0;
    assert!((f64::from(light[500][1]) / want - 1.0).abs() < 0.02, "{} {want}", light[500][1]);
    let out = stdout_of("expmerge", &words(&set_a, &a), b"");
    let (lines, ..) = split(&out);
    assert!(lines.iter().any(|l| l == "UNITS=relative"), "{lines:?}");
    assert!(lines.iter().any(|l| l.starts_with("CALIBRATION= none; nominal cd/m2")), "{lines:?}");
}

fn xy(rgb: &[f32; 3]) -> Xy {
    let m: Mat3 = Primaries::BT709.to_xyz().unwrap();
    Xy::of(m.apply(rgb.map(f64::from))).unwrap()
}

/// White and warm lamps from what every exposure sees to what none does: no tint, with noise and with a curve recovered for each
/// channel by itself.
#[test]
fn lamps_are_not_tinted() {
    let folder = tempfile::tempdir().unwrap();
    let walls: Vec<[f64; 3]> = (0..64 * 64).map(|i| [10f64.powf(-2.0 + 4.0 * f64::from(i % 64) / 63.0); 3]).collect();
    let lamp = |ratio: [f64; 3]| -> Vec<[f64; 3]> {
        let steps = (0..64 * 16).map(|i| 10f64.powf(0.5 + 4.0 * f64::from(i % 64) / 63.0));
        steps.map(|s| ratio.map(|r| r * s)).collect()
    };
    let (white, warm) = ([1.0; 3], [1.0, 0.75, 0.5]);
    let scene = [walls, lamp(white), lamp(warm)].concat();
    for (noise, curve) in [((0.0, 0.0), srgb as Curve), ((0.0015, 0.002), film)] {
        let shoot = Shoot { noise, ..Shoot::of(&scene, 64, curve) };
        let files = shoot.bracket(folder.path(), &TIMES);
        let got = merged(&["--times", TIMES_TEXT], &files);
        // The mean over the 16 rows of a lamp, which is what noise leaves of it.
        let mean = |first: usize, x: usize| {
            let rows = (0..16).map(|y| got[(first + y) * 64 + x]);
            rows.fold([0f32; 3], |s, p| [0, 1, 2].map(|c| s[c] + p[c]))
        };
        let (mut worst, mut worst_warm) = (0.0f64, 0.0f64);
        for x in 0..64 {
            let off = |got: Xy, want: Xy| (got.x / want.x - 1.0).abs().max((got.y / want.y - 1.0).abs());
            worst = worst.max(off(xy(&mean(64, x)), xy(&white.map(|c| c as f32))));
            // Up to what the shortest exposure shows unclipped.
            if 10f64.powf(0.5 + 4.0 * x as f64 / 63.0) < 800.0 {
                worst_warm = worst_warm.max(off(xy(&mean(80, x)), xy(&warm.map(|c| c as f32))));
            }
        }
        println!("white lamp within {:.2} % in xy, warm lamp within {:.2} %", 100.0 * worst, 100.0 * worst_warm);
        assert!(worst < 0.01 && worst_warm < 0.01, "{worst} {worst_warm}");
    }
}

fn capture(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| data_path(&format!("capture/{n}"))).collect()
}

/// Light of tests/ref/capture_files.py.
fn committed(x: usize, y: usize) -> [f64; 3] {
    const COLOUR: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, 0.6, 0.3], [0.4, 1.0, 0.5], [0.3, 0.5, 1.0]];
    match (x, y) {
        (56.., ..8) => [1000.0; 3],
        (..8, ..8) => [0.0; 3],
        _ => COLOUR[y / 16].map(|c| c * 10f64.powf(-1.5 + 3.0 * x as f64 / 63.0)),
    }
}

/// JPEG (baseline, progressive, turned by EXIF), PNG and TIFF (plain, LZW, Deflate), settings by EXIF, by options and by a list, name
/// the same light.
#[test]
fn files_of_all_kinds() {
    let folder = tempfile::tempdir().unwrap();
    let list = folder.path().join("bracket.hdrgen");
    for (name, f) in ["a.jpg", "b.jpg", "c.jpg"].into_iter().zip(capture(&["a.jpg", "b.jpg", "c.jpg"])) {
        fs::copy(f, folder.path().join(name)).unwrap();
    }
    fs::write(&list, "a.jpg 60 4 200 0\nb.jpg 8 4 200 0\nc.jpg 1 4 200 0\n").unwrap();
    let settings = ["--times", "1/60,1/8,1", "--aperture", "4", "--iso", "200", "--curve", "srgb"];
    let by_exif = merged(&["--curve", "srgb"], &capture(&["c.jpg", "a.jpg", "b.jpg"]));
    let png = merged(&settings, &capture(&["short.png", "middle.png", "long.png"]));
    let tiff = merged(&settings, &capture(&["a.tif", "b.tif", "c.tif"]));
    let turned = merged(&["--curve", "srgb"], &capture(&["turned.jpg", "b.jpg", "c.jpg"]));
    let listed = merged(&["--curve", "srgb", "--hdrgen", &text(&list)], &[]);
    assert_eq!(png, tiff);
    assert_eq!(by_exif, listed);
    let unit = 10.0 / (0.65 * 0.18) * 16.0 / 200.0;
    for (i, p) in png.iter().enumerate() {
        let want = committed(i % 64, i / 64);
        // The lamp and the black corner, and what is too dark for the codes, are bounds.
        if want[0] > 900.0 || want.iter().any(|w| *w < 0.03) {
            continue;
        }
        for c in 0..3 {
            let off = |x: f32| (f64::from(x) / (want[c] * unit) - 1.0).abs();
            assert!(off(p[c]) < 0.06, "{i}: {p:?} {want:?}");
            // JPEG adds a code or two to what was rounded.
            assert!(off(by_exif[i][c]) < 0.15 && off(turned[i][c]) < 0.15, "{i}: {:?} {want:?}", by_exif[i]);
        }
    }
    let mean = |pixels: &[[f32; 3]]| {
        let seen = (0..64 * 64).filter(|i| (16..48).contains(&(i % 64)) && i / 64 >= 16);
        let logs = seen.map(|i| (f64::from(pixels[i][1]) / committed(i % 64, i / 64)[1] / unit).ln());
        let logs: Vec<f64> = logs.collect();
        (logs.iter().map(|l| l * l).sum::<f64>() / logs.len() as f64).sqrt()
    };
    println!("rms of ln E: PNG {:.4}, JPEG {:.4}, one turned {:.4}", mean(&png), mean(&by_exif), mean(&turned));
    assert!(mean(&png) < 0.01 && mean(&by_exif) < 0.02 && mean(&turned) < 0.02);
}

#[test]
fn spots_make_it_absolute() {
    let files = capture(&["a.jpg", "b.jpg", "c.jpg"]);
    let luminance = |options: &[&str], x: usize, y: usize| {
        let y_row = Primaries::BT709.to_xyz().unwrap().0[1];
        let p = merged(options, &files)[y * 64 + x];
        p.iter().zip(y_row).map(|(a, b)| f64::from(*a) * b).sum::<f64>()
    };
    assert!((luminance(&["--spot", "30,20=1234.5"], 30, 20) / 1234.5 - 1.0).abs() < 1e-6);
    let out = stdout_of("expmerge", &words(&["--spot", "30,20=1234.5"], &files), b"");
    let (lines, ..) = split(&out);
    assert!(lines.iter().any(|l| l == "UNITS=cd/m2"), "{lines:?}");
    let factor = lines.iter().find_map(|l| l.strip_prefix("CALIBRATION= spot, factor ")).unwrap();
    let factor = factor.split(',').next().unwrap();
    assert!((luminance(&["--scale", factor], 30, 20) / 1234.5 - 1.0).abs() < 1e-5);
    // Two spots that contradict each other: the geometric mean, and a word.
    let two = run("expmerge", &words(&["--spot", "30,20=100", "--spot", "30,20=400"], &files), b"");
    assert!(String::from_utf8_lossy(&two.stderr).contains("disagree by up to 100 %"));
    assert!((luminance(&["--spot", "30,20=100", "--spot", "30,20=400"], 30, 20) / 200.0 - 1.0).abs() < 1e-6);
    for (spot, word) in
        [("60,2=10", "white in every"), ("2,2=10", "black in every"), ("64,0=1", "64 x 64"), ("1,1", "x,y=")]
    {
        let status = if spot == "1,1" { 2 } else { 1 };
        fails("expmerge", &words(&["--spot", spot], &files), b"", status, word);
    }
}

/// The mask marks the lamp and the black corner, and nothing else; threads change no byte.
#[test]
fn the_mask_and_the_threads() {
    let folder = tempfile::tempdir().unwrap();
    let mask = folder.path().join("mask.png");
    let files = capture(&["short.png", "middle.png", "long.png"]);
    let options = ["--times", "1/60,1/8,1", "--curve", "srgb", "--mask", mask.to_str().unwrap()];
    let output = run("expmerge", &words(&options, &files), b"");
    let notes = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && notes.contains("64 pixels (1.56 %) are white"), "{notes}");
    let one = stdout_of("expmerge", &words(&[&options[..], &["--threads", "1"]].concat(), &files), b"");
    assert!(one == output.stdout);
    let mut reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(&mask).unwrap())).read_info().unwrap();
    let mut levels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut levels).unwrap();
    for (i, level) in levels.iter().enumerate() {
        let want = match committed(i % 64, i / 64) {
            [e, ..] if e > 900.0 => 255,
            [0.0, ..] => 128,
            _ => 0,
        };
        assert_eq!(*level, want, "{} {}", i % 64, i / 64);
    }
    // A neutral lamp that no exposure holds is neutral, and a failure leaves no mask.
    let (_, _, pixels) = split(&one);
    let lamp = floats(pixels)[3 * 60..3 * 61].to_vec();
    assert!(lamp[0] == lamp[1] && lamp[1] == lamp[2] && lamp[0] >= 59.0, "{lamp:?}");
    fs::remove_file(&mask).unwrap();
    fails("expmerge", &words(&[&options[..], &["--spot", "99,99=1"]].concat(), &files), b"", 1, "99,99");
    assert!(!mask.exists());
}

/// A dome of one luminance behind a fisheye that loses half of it at the rim, through filters of other density for each channel.
#[test]
fn lenses_are_made_good() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height, radius) = (120usize, 100usize, 45.0);
    let arrives = |x: usize, y: usize| {
        let r = (x as f64 + 0.5 - 60.0).hypot(y as f64 + 0.5 - 50.0) / radius;
        if r <= 1.0 { 1.0 - 0.5 * r * r } else { 0.0 }
    };
    let filter = [0.1, 0.08, 0.05];
    let scene: Vec<[f64; 3]> =
        (0..width * height).map(|i| filter.map(|t| 40.0 * t * arrives(i % width, i / width))).collect();
    let files =
        Shoot { sixteen: true, ..Shoot::of(&scene, width, srgb) }.bracket(folder.path(), &[0.01, 0.05, 0.2, 1.0]);
    let lens = folder.path().join("lens.toml");
    fs::write(
        &lens,
        "projection = 'fisheye'\nfov_deg = 180\ncircle = [60, 50, 45]\ntransmittance = [0.1, 0.08, 0.05]\n\
         [vignetting]\npolynomial = [1, 0, -0.5]\n",
    )
    .unwrap();
    let options = ["--times", "0.01,0.05,0.2,1", "--curve", "srgb", "--lens", lens.to_str().unwrap()];
    let out = stdout_of("expmerge", &words(&options, &files), b"");
    let (lines, size, pixels) = split(&out);
    assert_eq!(size.split_whitespace().collect::<Vec<_>>(), ["-Y", "90", "+X", "90"]);
    assert!(lines.iter().any(|l| l == "VIEW= -vta -vh 180 -vv 180"), "{lines:?}");
    let mut inside = 0;
    for (i, p) in floats(pixels).as_chunks::<3>().0.iter().enumerate() {
        let r = ((i % 90) as f64 + 0.5 - 45.0).hypot((i / 90) as f64 + 0.5 - 45.0);
        if r > radius {
            assert_eq!(*p, [0.0; 3]);
        } else {
            assert!(p.iter().all(|x| (x / 40.0 - 1.0).abs() < 2e-3), "{i}: {p:?}");
            inside += 1;
        }
    }
    assert!(inside > 6000);
    for (toml, word) in
        [("circle = [60, 50, 61]", "120 x 100"), ("fov = 3", "line 1, column 1"), ("[vignetting]", "expected radius")]
    {
        fs::write(&lens, toml).unwrap();
        fails("expmerge", &words(&options, &files), b"", 1, word);
    }
}

/// A camera whose channels are a matrix of XYZ sees a chart: XYZ comes out, and the matrix serves other brackets.
#[test]
fn a_chart_gives_xyz() {
    let folder = tempfile::tempdir().unwrap();
    let camera = Mat3([[0.7, 0.25, -0.05], [-0.2, 1.1, 0.1], [0.02, -0.1, 0.8]]);
    let patches =
        [[0.3, 0.2, 0.1], [0.2, 0.3, 0.15], [0.15, 0.1, 0.5], [0.9, 1.0, 1.1], [0.1, 0.1, 0.1], [0.5, 0.6, 0.1]];
    let scene: Vec<[f64; 3]> = (0..60 * 10).map(|i| camera.apply(patches[i % 60 / 10]).map(|x| 20.0 * x)).collect();
    let files = Shoot { sixteen: true, ..Shoot::of(&scene, 60, srgb) }.bracket(folder.path(), &[0.01, 0.04, 0.16]);
    let (chart, saved) = (folder.path().join("chart.toml"), folder.path().join("camera.txt"));
    let patch = |(i, p): (usize, &[f64; 3])| {
        let xyz = p.map(|x| 1000.0 * x);
        format!("[[patch]]\nrect = [{}, 2, 6, 6]\nxyz = [{}, {}, {}]\n", 10 * i + 2, xyz[0], xyz[1], xyz[2])
    };
    fs::write(&chart, patches.iter().enumerate().map(patch).collect::<String>()).unwrap();
    let options = ["--times", "0.01,0.04,0.16", "--curve", "srgb"];
    let by_chart =
        [&options[..], &["--chart", chart.to_str().unwrap(), "--save-camera", saved.to_str().unwrap()]].concat();
    let output = run("expmerge", &words(&by_chart, &files), b"");
    assert!(String::from_utf8_lossy(&output.stderr).contains("chart: CIEDE2000 0.0"), "{:?}", output.stderr);
    let (lines, _, pixels) = split(&output.stdout);
    for line in ["COMPONENTS=XYZ", "UNITS=cd/m2", "CALIBRATION= chart"] {
        assert!(lines.iter().any(|l| l == line), "{line} not in {lines:?}");
    }
    let pixels = floats(pixels);
    for (i, p) in patches.iter().enumerate() {
        let at = 3 * (5 * 60 + 10 * i + 5);
        for c in 0..3 {
            assert!((f64::from(pixels[at + c]) / (1000.0 * p[c]) - 1.0).abs() < 2e-3, "{i}: {:?}", &pixels[at..at + 3]);
        }
    }
    // The saved matrix and one spot say the same.
    let by_camera = [&options[..], &["--camera", saved.to_str().unwrap(), "--spot", "35,5=1000"]].concat();
    let again = merged(&by_camera, &files);
    assert!((again[5 * 60 + 5][0] / 300.0 - 1.0).abs() < 2e-3, "{:?}", again[5 * 60 + 5]);
    fs::write(&saved, "1 0 0 0 1 0 0 0 0").unwrap();
    fails("expmerge", &words(&by_camera, &files), b"", 1, "camera.txt: ");
    fs::write(&chart, "[[patch]]\nrect = [0, 0, 99, 1]\nxyz = [1, 1, 1]\n".repeat(3)).unwrap();
    fails("expmerge", &words(&by_chart, &files), b"", 1, "patch 1");
}

/// One line that names the file, and status 1.
#[test]
fn bad_brackets_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, width: usize, code: u16| {
        let path = folder.path().join(name);
        png(&path, width, &vec![code; 3 * width * 8], false);
        text(&path)
    };
    let bracket = |names: [&str; 2], code: u16| names.map(|n| file(n, 8, code)).to_vec();
    let times = ["--times", "0.1,1"];
    fails("expmerge", &words(&times, &bracket(["w1.png", "w2.png"], 255)), b"", 1, "w1.png: all white");
    fails("expmerge", &words(&times, &bracket(["k1.png", "k2.png"], 0)), b"", 1, "k2.png: all black");
    let unlike = [file("a.png", 8, 100), file("b.png", 9, 100)];
    fails("expmerge", &words(&times, &unlike), b"", 1, "b.png: is 9 x 8 pixels");
    fails("expmerge", &words(&[], &bracket(["c.png", "d.png"], 100)), b"", 1, "c.png: no exposure time");
    let good = bracket(["e.png", "f.png"], 100);
    fails("expmerge", &words(&["--times", "1,2,3"], &good), b"", 2, "--times has 3 numbers for 2");
    fails("expmerge", &words(&["--times", "1,1"], &good), b"", 1, "e.png: all exposures let in the same");
    // Every pixel one code in both: 100 at both exposures fits no rising curve, but it is no crash.
    assert!(run("expmerge", &words(&times, &good), b"").status.code().is_some_and(|c| c < 2));
    fails("expmerge", &words(&["--times", "1"], &good[..1]), b"", 1, "e.png");
    fails("expmerge", &[&good[0], &good[0]], b"", 1, "is named twice");
    fails("expmerge", &[], b"", 2, "EXPOSURE");
    fails("expmerge", &["/nowhere/at/all.jpg"], b"", 1, "/nowhere/at/all.jpg: No such file");
    fails("expmerge", &["/tmp"], b"", 1, "folder");
    fails("expmerge", &[&data_path("small.pfm")], b"", 1, "small.pfm: is no JPEG, PNG or TIFF");
    let deep = folder.path().join("deep.png");
    png(&deep, 8, &[100; 3 * 64], true);
    fails("expmerge", &words(&times, &[good[0].clone(), text(&deep)]), b"", 1, "deep.png: has 16 bits a channel");
    let curve = folder.path().join("curve.txt");
    fs::write(&curve, "0 0\n1 -1\n").unwrap();
    fails("expmerge", &words(&["--curve", curve.to_str().unwrap()], &capture(&["a.jpg"])), b"", 1, "curve.txt: line 2");
}

/// One exposure and a known curve are a picture too.
#[test]
fn one_exposure_with_a_curve() {
    let out = merged(&["--curve", "srgb", "--spot", "30,20=50"], &capture(&["b.jpg"]));
    assert_eq!(out.len(), 64 * 64);
    fails("expmerge", &[&capture(&["b.jpg"])[0]], b"", 1, "b.jpg: all exposures let in the same");
}

/// Cut and bent files: an error or a picture, never anything else.
#[test]
fn damaged_files_end_in_order() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.jpg", "b.jpg", "b.tif", "c.tif", "middle.png"] {
        let whole = fs::read(data_path(&format!("capture/{name}"))).unwrap();
        let path: PathBuf = folder.path().join(name);
        let ends = |bytes: &[u8], cut: bool| {
            fs::write(&path, bytes).unwrap();
            let output = run("expmerge", &["--curve", "srgb", "--times", "1", path.to_str().unwrap()], b"");
            let message = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code();
            assert!(code == Some(1) || code == Some(0) && !cut, "{name} of {}: {code:?} {message}", bytes.len());
            assert!(code == Some(0) || message.lines().count() == 1 && message.contains(name), "{name}: {message}");
        };
        let steps = 12;
        for i in 1..steps {
            ends(&whole[..whole.len() * i / steps], true);
            let mut bent = whole.clone();
            bent[whole.len() * i / steps] ^= 0x55;
            ends(&bent, false);
        }
    }
}
