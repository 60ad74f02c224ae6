//! What each program reads, and the words it reads it with: `{in}` is the damaged file, `{out}` the output, `{side}` a file beside it
//! that names `{in}`. Renders are tiny.

use std::path::Path;
use std::sync::Arc;

use crate::corpus::{self, Seed};
use crate::run::root;

/// A way to hand a program a file.
pub struct Reader {
    /// The program.
    pub program: &'static str,
    /// Its words; standard input is `{in}` where `stdin` is set.
    pub words: Vec<String>,
    /// Is the file standard input?
    pub stdin: bool,
    /// Text of a file beside it.
    pub side: Option<String>,
    /// Whole files.
    pub seeds: Vec<Arc<Seed>>,
}

fn reader(program: &'static str, words: &str, seeds: &[Arc<Seed>]) -> Reader {
    let place = |w: &str| w.replace("{root}", &root().display().to_string()).replace('~', " ");
    let words = words.split(' ').filter(|w| !w.is_empty()).map(place).collect();
    Reader { program, words, stdin: false, side: None, seeds: seeds.to_vec() }
}

impl Reader {
    fn stdin(self) -> Reader {
        Reader { stdin: true, ..self }
    }

    fn beside(self, text: String) -> Reader {
        Reader { side: Some(text), ..self }
    }
}

/// Files that readers name beside what is damaged, in `folder`.
pub fn companions(folder: &Path) -> std::io::Result<()> {
    std::fs::write(folder.join("base.lux"), corpus::xyz())?;
    std::fs::write(folder.join("shown.lux"), corpus::shown())?;
    let shown = corpus::made("pcond", &["--display", "displays/srgb.toml", "--quiet"], &corpus::xyz())?;
    std::fs::write(folder.join("srgb.lux"), corpus::made("xyz2rgb", &["--quiet"], &shown)?)?;
    let plan = corpus::made("specplan", &["--pilot=16", "--threads=1", "--quiet", "scenes/cornell.toml"], b"")?;
    std::fs::write(folder.join("cornell.plan"), plan)?;
    for (name, target) in [
        ("luminaires", "scenes/luminaires"),
        ("tower", "scenes/tower"),
        ("cube data.bin", "tests/data/mesh/cube data.bin"),
    ] {
        std::os::unix::fs::symlink(root().join(target), folder.join(name))?;
    }
    Ok(())
}

const TINY: &str = "--width 4 --height 4 --samples 1 --bands 4";

/// Readers of pictures.
fn of_pictures(seeds: &[Arc<Seed>]) -> Vec<Reader> {
    let stage = |run: &str| format!("[[stage]]\nrun = \"{run}\"\ninput = \"{{in}}\"\noutput = \"{{out}}\"\n");
    let mut all = vec![
        reader("vonkries", "--from A {in} {out}", seeds),
        reader("vonkries", "--from A - {out}", seeds).stdin(),
        reader("xyz2rgb", "{in} {out}", seeds),
        reader("xyz2rgb", "--gamut compress {in} {out}", seeds),
        reader("xyz2rgb", "-r {in} {out}", seeds),
        reader("xyz2rgb", "- {out}", seeds).stdin(),
        reader("ra_exr", "-r - {out}", seeds).stdin(),
        reader("pcond", "{in} {out}", seeds),
        reader("pcond", "-h {in} {out}", seeds),
        reader("plocal", "{in} {out}", seeds),
        reader("pglare", "--view -vta~-vh~180~-vv~180 {in} {out}", seeds),
        reader("falsecolor", "{in} {out}", seeds),
        reader("picinfo", "{in} {out}", seeds),
        reader("picinfo", "--histogram {in} {out}", seeds),
        reader("picinfo", "--json {in} {out}", seeds),
        reader("pcompare", "base.lux {in} {out}", seeds),
        reader("pcompare", "{in} base.lux {out}", seeds),
        reader("pmix", "{in} --weight 0.5 {out}", seeds),
        reader("pmix", "base.lux --add {in} {out}", seeds),
        reader("pjoin", "{in} -o {out}", seeds),
        reader("pplot", "--histogram {in} --kind svg {out}", seeds),
        reader("spec2xyz", "{in} {out}", seeds),
        reader("specmat", "--finish {root}/palettes/office.toml {out}", seeds).stdin(),
        reader("luxpipe", "{side}", seeds).beside(stage("vonkries")),
        reader("luxpipe", "--intent perceptual {in}", seeds),
        reader("spectrace", &format!("{TINY} {{side}} {{out}}"), seeds).beside(corpus::scene_with("texture")),
        reader("spectrace", &format!("{TINY} {{side}} {{out}}"), seeds).beside(corpus::scene_with("sky")),
    ];
    for name in ["ra_rgbe", "ra_loglv", "ra_pixlog", "ra_pfm", "ra_exr", "ra_png"] {
        all.push(reader(name, "{in} {out}", seeds));
        all.push(reader(name, "-r {in} {out}", seeds));
    }
    all
}

/// Readers of scenes and of what scenes name.
fn of_scenes() -> std::io::Result<Vec<Reader>> {
    let scenes = [
        "cornell",
        "materials",
        "sphere",
        "fog",
        "fluorescence",
        "films",
        "prism",
        "brewster",
        "luminaires",
        "skin",
        "marble",
        "haze",
    ];
    let scenes: Vec<_> = scenes.iter().map(|s| Seed::of(&format!("scenes/{s}.toml"))).collect::<Result<_, _>>()?;
    let meshes = [
        "scenes/tower/desk.obj",
        "tests/data/mesh/cube.gltf",
        "tests/data/mesh/cube.glb",
        "tests/data/mesh/cube_base64.gltf",
    ];
    let mut meshes: Vec<_> = meshes.iter().map(|m| Seed::of(m)).collect::<Result<_, _>>()?;
    meshes.extend(corpus::polygons());
    let luminaires = ["batwing", "lambertian", "skew"];
    let luminaires: Vec<_> =
        luminaires.iter().map(|s| Seed::of(&format!("tests/data/ies/{s}.ies"))).collect::<Result<_, _>>()?;
    let tables = spectra()?;
    let matrix = "nm,400,500,600\n400,0.5,0,0\n500,0.2,0.6,0\n600,0,0.1,0.7\n";
    let trace = |options: &str| format!("{options} {TINY} {{in}} {{out}}");
    let beside = |what: &str, seeds: &[Arc<Seed>]| {
        reader("spectrace", &format!("{TINY} {{side}} {{out}}"), seeds).beside(corpus::scene_with(what))
    };
    Ok(vec![
        reader("spectrace", &trace(""), &scenes),
        reader("spectrace", &trace("--method local"), &scenes),
        reader("spectrace", &trace("--method radiosity --divide 1 --element-rays 4"), &scenes),
        reader("spectrace", &trace("--method photon --photons 100 --passes 1 --count 8"), &scenes),
        reader("spectrace", &trace("--method march --step 1"), &scenes),
        reader("spectrace", &trace("--method zonal --zones 1 --element-rays 4 --step 1"), &scenes),
        reader("specplan", "--pilot 16 {in} {out}", &scenes),
        reader("specprobe", "--material gold {in} {out}", &scenes[1..2]),
        reader("specprobe", "--medium marble --radii 1,2 {in} {out}", &scenes[10..11]),
        reader("relight", "{in} layers.lux {out}", &scenes[..1]),
        reader(
            "tradeoff",
            "{in} --width 4 --samples 1 --methods local --plans none --seconds 0.001 --reference-seconds 0.001 -o {out}",
            &scenes[..1],
        ),
        beside("mesh", &meshes),
        beside("luminaire", &luminaires),
        beside("spectrum", &tables),
        beside("matrix", &[Seed::new("matrix.csv", matrix.into(), true)]),
        beside("voxels", &[corpus::voxels()]),
    ])
}

/// Tables of spectra, sparse and fine.
fn spectra() -> std::io::Result<Vec<Arc<Seed>>> {
    ["cornell_white", "cc_ohta_05_blue_flower", "glass_BK7_n"]
        .iter()
        .map(|s| Seed::of(&format!("spectra/{s}.csv")))
        .collect()
}

/// Readers of lines, tables and descriptions.
fn of_texts() -> std::io::Result<Vec<Reader>> {
    let cornell = "{root}/scenes/cornell.toml";
    let text = |name: &str, text: &str| Seed::new(name, text.into(), true);
    let rays = [text("rays.txt", "278 273 -799 0 0 1\n100 100 100 0 0.6 0.8\n278 273 100 1 0 0\n")];
    let floats: Vec<u8> = [278f32, 273.0, -799.0, 0.0, 0.0, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let plan = [Seed::new(
        "cornell.plan",
        corpus::made("specplan", &["--pilot=16", "--threads=1", "--quiet", "scenes/cornell.toml"], b"")?,
        true,
    )];
    let displays = ["crt", "hdr10", "p3", "print", "srgb"];
    let displays: Vec<_> =
        displays.iter().map(|d| Seed::of(&format!("displays/{d}.toml"))).collect::<Result<_, _>>()?;
    let pipelines = [pipeline()];
    let readings = [Seed::of("tests/data/display_readings.csv")?];
    let palettes = [Seed::of("palettes/office.toml")?, Seed::of("palettes/colorchecker.csv")?];
    let map = [Seed::new("curve.map", curve(), true)];
    let histogram = [Seed::new("bars.txt", corpus::made("picinfo", &["--histogram"], &corpus::xyz())?, true)];
    let calibration = [Seed::of("tests/data/macbeth_print.cal")?, Seed::of("tests/data/macbeth_scan.cal")?];
    Ok(vec![
        reader("spectrace", &format!("--rays --bands 4 {cornell} {{out}}"), &rays).stdin(),
        reader("spectrace", &format!("--irradiance --samples 1 --bands 4 {cornell} {{out}}"), &rays).stdin(),
        reader(
            "spectrace",
            &format!("--rays --float --bands 4 {cornell} {{out}}"),
            &[Seed::new("rays", floats, false)],
        )
        .stdin(),
        reader("spectrace", &format!("--plan {{in}} --width 4 --height 4 --samples 1 {cornell} {{out}}"), &plan),
        reader(
            "specprobe",
            "--material satin --pairs {root}/scenes/materials.toml {out}",
            &[text("pairs.txt", "30 0 30 180\n10 0 10 90\n")],
        )
        .stdin(),
        reader("luxpipe", "--dry-run {in}", &pipelines),
        reader("luxpipe", "--make {in}", &pipelines),
        reader("luxpipe", "--snakemake {in}", &pipelines),
        reader("luxpipe", "{in}", &pipelines),
        reader("vonkries", "--display {in} base.lux {out}", &displays),
        reader("pcond", "--display {in} base.lux {out}", &displays),
        reader("ra_png", "--display {in} srgb.lux {out}", &displays[4..]),
        reader("pcond", "--calibration {in} base.lux {out}", &calibration),
        reader("pcond", "--histogram {in} base.lux {out}", &histogram),
        reader("pcond", "--fixations {in} base.lux {out}", &[text("eyes.txt", "3 4\n5 6\n10 2\n")]),
        reader("pdisplay", "{in} {out}", &readings),
        reader("pdisplay", "--check srgb --tolerance 100 {in} {out}", &readings),
        reader("pdisplay", "--macbethcal {in} {out}", &calibration[..1]),
        reader("specmat", "{in} --source A {out}", &palettes),
        reader("specmat", "--material x={in} --source A", &spectra()?),
        reader("pplot", "--spectrum {in} --kind svg {out}", &spectra()?),
        reader("pplot", "--chart {in} --kind png {out}", &readings),
        reader("pplot", "--curve {in} --kind svg {out}", &map),
        reader("pplot", "--histogram {in} --kind svg {out}", &histogram),
    ])
}

/// A tone curve in the words of pcond -x.
fn curve() -> Vec<u8> {
    (1..30)
        .map(|i| format!("{:e} {:e}\n", f64::from(i) * 3.0, f64::from(i).sqrt() * 5.0))
        .collect::<String>()
        .into_bytes()
}

/// A pipeline with variables, jobs, branches and another program.
fn pipeline() -> Arc<Seed> {
    let text = "name = \"proof\"\n[set]\nout = \"out-${n}\"\nwhite = \"D65\"\n[foreach]\nn = { from = 1, to = 2, step = 1, digits = 2 }\n\
        [[stage]]\nrun = \"vonkries\"\ninput = \"base.lux\"\nfrom = \"A\"\nto = \"${white}\"\nid = \"adapted\"\nsave = [\"${out}.hdr\"]\n\
        [[stage]]\nrun = \"pcond\"\ndisplay = \"srgb\"\n[[stage]]\nrun = \"xyz2rgb\"\ngamut = \"clip\"\n[[stage]]\nrun = \"ra_png\"\nbits = 8\n\
        output = \"${out}.png\"\n[[stage]]\nexec = [\"cat\"]\nafter = \"adapted\"\nformat = \"rgbe\"\noutput = \"${out}-cat.hdr\"\n";
    Seed::new("proof.toml", text.into(), true)
}

/// Files that spectrace keeps between runs.
fn of_kept(folder: &Path) -> std::io::Result<Vec<Reader>> {
    let cornell = root().join("scenes/cornell.toml").display().to_string();
    let words = |extra: &[&str], out: &str| -> Vec<String> {
        let tiny = ["--width", "16", "--height", "16", "--samples", "1", "--bands", "4", "--quiet"];
        extra.iter().chain(&tiny).map(|w| w.to_string()).chain([cornell.clone(), out.to_string()]).collect()
    };
    let mut all = Vec::new();
    for (kind, extra) in
        [("--checkpoint", &[][..]), ("--solution", &["--method", "radiosity", "--divide", "1", "--element-rays", "4"])]
    {
        let file = folder.join(format!("kept{kind}"));
        let extra: Vec<&str> =
            [kind, file.to_str().unwrap_or_default()].into_iter().chain(extra.iter().copied()).collect();
        // A picture that finds no room leaves the rows that are done.
        crate::run::run(&mut crate::run::filter("spectrace", &words(&extra, "/dev/full"), folder), b"")?;
        let seed = Seed::new(kind, std::fs::read(&file)?, false);
        let given: Vec<&str> =
            extra.iter().map(|w| if *w == file.to_str().unwrap_or_default() { "{in}" } else { w }).collect();
        all.push(Reader {
            program: "spectrace",
            words: words(&given, "{out}"),
            stdin: false,
            side: None,
            seeds: vec![seed],
        });
    }
    Ok(all)
}

/// Readers of photographs, and of scenes written for Radiance.
fn of_others() -> std::io::Result<Vec<Reader>> {
    let seeds = |folder: &str, names: &[&str]| -> std::io::Result<Vec<Arc<Seed>>> {
        names.iter().map(|n| Seed::of(&format!("tests/data/{folder}/{n}"))).collect()
    };
    let shots = seeds("capture", &["a.jpg", "turned.jpg", "short.png", "a.tif", "b.tif", "c.tif"])?;
    let scenes = seeds("rad", &["desk.rad", "room.mat", "sky.rad", "daylit.rad", "studio.rad"])?;
    Ok(vec![
        reader("expmerge", "--times 1/60 --aperture 8 --iso 100 --curve srgb {in} -o {out}", &shots),
        reader("rad2scene", "{in} -o {out}", &scenes),
        reader("rad2scene", "--skip-unknown {in} -o {out}", &scenes),
    ])
}

/// Every reader; `folder` has their companions.
pub fn all(folder: &Path) -> std::io::Result<Vec<Reader>> {
    let layers = corpus::layers()?;
    std::fs::write(folder.join("layers.lux"), &layers.bytes)?;
    let mut all = of_pictures(&corpus::pictures()?);
    all.push(reader("relight", "{root}/scenes/cornell.toml {in} {out}", &[layers]));
    all.extend(of_scenes()?);
    all.extend(of_texts()?);
    all.extend(of_kept(folder)?);
    all.extend(of_others()?);
    for filter in luxpipe::filters::ALL {
        assert!(all.iter().any(|r| r.program == filter.name()), "{} reads nothing here", filter.name());
    }
    Ok(all)
}
