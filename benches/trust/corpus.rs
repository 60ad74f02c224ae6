//! Whole files of every kind that a program reads: made by our own programs, or of tests/data, scenes and the other folders.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use crate::guard::Guard;
use crate::run::{filter, program, root, run};

/// A whole file.
pub struct Seed {
    /// What it is called in messages.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// With its dot.
    pub suffix: String,
    /// Do people write it?
    pub text: bool,
    /// What damage it shows.
    pub guard: Guard,
}

impl Seed {
    /// A file; the suffix is its name's.
    pub fn new(name: &str, bytes: Vec<u8>, text: bool) -> Arc<Seed> {
        let suffix = Path::new(name).extension().map_or(String::new(), |s| format!(".{}", s.to_string_lossy()));
        let guard = if text { Guard::default() } else { Guard::of(&bytes) };
        Arc::new(Seed { name: name.to_string(), bytes, suffix, text, guard })
    }

    /// A file of the package.
    pub fn of(path: &str) -> std::io::Result<Arc<Seed>> {
        let text = [".toml", ".csv", ".obj", ".gltf", ".ies", ".cal", ".map", ".rad", ".mat"]
            .iter()
            .any(|s| path.ends_with(s));
        Ok(Seed::new(path.rsplit('/').next().unwrap_or(path), fs::read(root().join(path))?, text))
    }
}

/// A float stream of 20 x 9 pixels.
pub fn stream(lines: &str, components: usize, top: f32) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\n{lines}\nFORMAT=float\n\n-Y 9 +X 20\n").into_bytes();
    for i in 0..180 * components {
        bytes.extend((top * (0.1 + 0.9 * ((i * 7919 % 997) as f32 / 997.0))).to_le_bytes());
    }
    bytes
}

/// XYZ in cd/m2: what most filters read.
pub fn xyz() -> Vec<u8> {
    stream("NCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329\nVIEW= -vtv -vh 40 -vv 30", 3, 90.0)
}

/// Linear RGB for a display.
pub fn shown() -> Vec<u8> {
    let white = "UNITS=display\nDISPLAY= 1 100\nPRIMARIES= .64 .33 .3 .6 .15 .06 .3127 .329";
    stream(&format!("NCOMP=3\nCOMPONENTS=RGB\n{white}"), 3, 1.0)
}

/// A spectrum of five bins.
pub fn spectrum() -> Vec<u8> {
    stream("NCOMP=5\nCOMPONENTS=SPECTRUM\nWAVELENGTH_SPLITS= 780 588 480 380", 5, 0.1)
}

/// What a program writes to standard output.
pub fn made(name: &str, words: &[&str], input: &[u8]) -> std::io::Result<Vec<u8>> {
    let words: Vec<String> = words.iter().map(|w| w.to_string()).collect();
    let ended = run(&mut filter(name, &words, &root()), input)?;
    match ended.status {
        0 => Ok(ended.stdout),
        _ => Err(std::io::Error::other(format!("{name} {words:?}: {}", ended.stderr.trim()))),
    }
}

/// Pictures in every coding.
pub fn pictures() -> std::io::Result<Vec<Arc<Seed>>> {
    let (xyz, shown, spectrum) = (xyz(), shown(), spectrum());
    let mut all = vec![
        Seed::new("xyz.lux", xyz.clone(), false),
        Seed::new("shown.lux", shown.clone(), false),
        Seed::new("spectrum.lux", spectrum.clone(), false),
        Seed::new("luminance.lux", stream("NCOMP=1\nCOMPONENTS=Y\nUNITS=cd/m2", 1, 50.0), false),
    ];
    let codings: [(&str, &[&str], &[u8], &str); 17] = [
        ("ra_rgbe", &[], &xyz, "rgbe.hdr"),
        ("ra_rgbe", &["--xyze"], &xyz, "xyze.hdr"),
        ("ra_rgbe", &["--spectra"], &spectrum, "spectra.hsr"),
        ("ra_loglv", &[], &xyz, "logluv.tif"),
        ("ra_loglv", &["--bits24"], &xyz, "logluv24.tif"),
        ("ra_loglv", &["--luminance"], &xyz, "logl.tif"),
        ("ra_pixlog", &["--force"], &shown, "pixarlog.tif"),
        ("ra_pixlog", &[], &xyz, "pixarlog-xyz.tif"),
        ("ra_pfm", &[], &xyz, "floats.pfm"),
        ("ra_pfm", &["--big-endian"], &xyz, "big.pfm"),
        ("ra_exr", &["--half"], &xyz, "half.exr"),
        ("ra_exr", &["--float"], &xyz, "float.exr"),
        ("ra_exr", &["--compression", "none"], &xyz, "none.exr"),
        ("ra_exr", &["--compression", "piz"], &xyz, "piz.exr"),
        ("ra_exr", &[], &spectrum, "spectrum.exr"),
        ("ra_png", &[], &shown, "eight.png"),
        ("ra_png", &["--bits", "16"], &shown, "sixteen.png"),
    ];
    for (name, words, input, file) in codings {
        all.push(Seed::new(file, made(name, words, input)?, false));
    }
    for folder in ["tests/data", "tests/data/exr", "tests/data/png", "tests/data/tiff"] {
        let mut paths: Vec<_> = fs::read_dir(root().join(folder))?.flatten().map(|e| e.path()).collect();
        paths.sort();
        for path in paths.iter().filter(|p| p.metadata().is_ok_and(|m| m.is_file() && m.len() < 12_000)) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let reads = Command::new(program("ra_rgbe")).args(["-r", "--quiet"]).arg(path).arg("/dev/null").output()?;
            if reads.status.success() {
                all.push(Seed::new(&name, fs::read(path)?, false));
            }
        }
    }
    Ok(all)
}

/// Layers of the Cornell box.
pub fn layers() -> std::io::Result<Arc<Seed>> {
    let words =
        ["--width=4", "--height=4", "--samples=1", "--bands=4", "--threads=1", "--per-light", "scenes/cornell.toml"];
    Ok(Seed::new("layers.lux", made("spectrace", &words, b"")?, false))
}

/// A scene with a mesh, a spectrum, a luminaire file, a matrix or voxels of a file: `{in}` stands for its name.
pub fn scene_with(what: &str) -> String {
    let camera = "[camera]\norigin = [0, -4, 1]\ntarget = [0, 0, 0.5]\nup = [0, 0, 1]\nfov_deg = 40\nwidth = 4\n";
    let paint = match what {
        "spectrum" => "[materials.paint]\nreflectance = \"{in}\"\n",
        "matrix" => "[materials.paint]\ntype = \"fluorescent\"\nmatrix = \"{in}\"\n",
        "texture" => "[materials.paint]\ntexture = { type = \"picture\", file = \"{in}\" }\n",
        _ => "[materials.paint]\nreflectance = 0.5\n",
    };
    let light = match what {
        "luminaire" => {
            "[lights.lamp]\ntype = \"ies\"\nspectrum = \"D65\"\nfile = \"{in}\"\nposition = [0, 0, 3]\nlumens = 900\n"
        }
        _ => "[lights.lamp]\ntype = \"point\"\nspectrum = \"D65\"\nposition = [0, -2, 3]\nlumens = 900\n",
    };
    let around = match what {
        "sky" => "[environment]\ntype = \"picture\"\nfile = \"{in}\"\n",
        _ => "[environment]\ntype = \"uniform\"\nspectrum = \"E\"\nluminance = 5\n",
    };
    let more = match what {
        "mesh" => "[[shape]]\ntype = \"mesh\"\nfile = \"{in}\"\nmaterial = \"paint\"\ndegenerate = \"skip\"\n".to_string(),
        "voxels" => "[media.smoke]\nscattering = 2\ndensity = { grid = { file = \"{in}\" } }\n[materials.skin]\n\
            type = \"boundary\"\ninterior = \"smoke\"\n[[shape]]\ntype = \"box\"\nmin = [-1, -1, 0]\nmax = [1, 1, 2]\nmaterial = \"skin\"\n"
            .to_string(),
        _ => String::new(),
    };
    let floor =
        "[[shape]]\ntype = \"quad\"\nmaterial = \"paint\"\npoints = [[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]\n";
    [camera, paint, light, around, floor, &more].concat()
}

/// Voxels as Mitsuba keeps them.
pub fn voxels() -> Arc<Seed> {
    let mut bytes = b"VOL\x03".to_vec();
    [1i32, 3, 3, 3, 1].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    [-1f32, -1.0, 0.0, 1.0, 1.0, 2.0].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    (0..27).for_each(|i| bytes.extend((i as f32 / 27.0).to_le_bytes()));
    Seed::new("smoke.vol", bytes, false)
}

/// Polygons as text and in both orders of bytes.
pub fn polygons() -> Vec<Arc<Seed>> {
    let places = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
    let head = |format: &str| {
        let list = "element face 2\nproperty list uchar int vertex_indices";
        let place = "property float x\nproperty float y\nproperty float z";
        format!("ply\nformat {format} 1.0\nelement vertex 4\n{place}\n{list}\nend_header\n")
    };
    let text = head("ascii") + "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n3 0 2 3\n";
    let binary = |big: bool| {
        let mut bytes = head(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let word = |b: [u8; 4]| if big { [b[3], b[2], b[1], b[0]] } else { b };
        places.iter().flatten().for_each(|x| bytes.extend(word(x.to_le_bytes())));
        for face in [[0i32, 1, 2], [0, 2, 3]] {
            bytes.push(3);
            face.iter().for_each(|i| bytes.extend(word(i.to_le_bytes())));
        }
        bytes
    };
    vec![
        Seed::new("text.ply", text.into_bytes(), true),
        Seed::new("little.ply", binary(false), false),
        Seed::new("big.ply", binary(true), false),
    ]
}
