//! Rays a second on one thread: a mesh of 212 thousand triangles in a room, and the Cornell box; how long a tree takes to
//! build, and what it weighs.
//!
//! Primary rays come from a camera in rows; diffuse ones leave where those arrive, about the normal; shuffled are the same
//! in random order, as a tracer's later bounces are. "any" asks only whether there is something.
//!
//! EMBREE_RAYS names a program made of benches/embree_rays.cpp: Embree then answers the same rays in the same run, in turn
//! with us, and the median of the ratios counts.

use std::io::Write;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use glam::{Vec3A, vec3a};
use luxpipe::scene::geometry::{Geometry, Primitive, Surface};
use luxpipe::scene::ray::{cosine_direction, offset};

const WIDTH: usize = 512;
const RUNS: usize = 7;
/// Half the Cornell box, mm.
const MIDDLE: f32 = 278.0;
const NAMES: [&str; 6] =
    ["primary, closest", "primary, any", "diffuse, closest", "diffuse, any", "shuffled, closest", "shuffled, any"];

type Rays = Vec<(Vec3A, Vec3A)>;

fn main() -> std::io::Result<()> {
    // `cargo test --benches` runs this too; one small run then shows that it works.
    let (runs, width) = if std::env::args().any(|a| a == "--bench") { (RUNS, WIDTH) } else { (1, 32) };
    let peer = std::env::var("EMBREE_RAYS").ok();
    println!("one thread, medians of {runs}; {}", processor());
    let mesh = room();
    let box_ = cornell();
    scene("mesh", mesh, [vec3a(0.0, 4.5, -13.0), vec3a(0.0, 3.6, 0.0)], width, runs, peer.as_deref())?;
    let view = [vec3a(278.0, 273.0, -800.0), vec3a(278.0, 273.0, 0.0)].map(framed);
    scene("Cornell box", box_, view, width, runs, peer.as_deref())?;
    build(if runs > 1 { 707 } else { 50 }, runs.min(3));
    Ok(())
}

fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("unknown processor");
    name.trim_start_matches([' ', '\t', ':']).to_string()
}

fn built(primitives: Vec<Primitive>) -> Geometry {
    let surfaces = vec![Surface { material: 0, emitter: None }; primitives.len()];
    Geometry::build(primitives, surfaces).expect("the scene has shapes")
}

fn build(n: usize, runs: usize) {
    let primitives = height_field(n, &mut Random(3));
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let (primitives, start) = (primitives.clone(), Instant::now());
            let geometry = built(primitives);
            let time = start.elapsed().as_secs_f64();
            drop(geometry);
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let bytes = built(primitives.clone()).bytes() as f64 / primitives.len() as f64;
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    println!("build of {} triangles on {threads} processors: {:.2} s", primitives.len(), times[runs / 2]);
    println!("memory: {bytes:.1} bytes a triangle, surfaces included");
}

/// Times all kinds of rays through one scene.
fn scene(
    name: &str,
    primitives: Vec<Primitive>,
    view: [Vec3A; 2],
    width: usize,
    runs: usize,
    peer: Option<&str>,
) -> std::io::Result<()> {
    let triangles: Vec<[Vec3A; 3]> = primitives.iter().flat_map(split).collect();
    println!("\n{name}: {} surfaces, {} triangles", primitives.len(), triangles.len());
    let geometry = built(primitives);
    let sets = rays(&geometry, view, width);
    let file = tempfile::NamedTempFile::new()?;
    if peer.is_some() {
        write(file.path(), &triangles, &sets)?;
    }
    let (mut ours, mut ratios) = (vec![Vec::new(); 6], vec![Vec::new(); 6]);
    for _ in 0..runs {
        let theirs = peer.and_then(|p| embree(p, file.path()));
        for i in 0..6 {
            let (rate, hits) = rate(&geometry, &sets[i / 2], i % 2 == 1);
            ours[i].push(rate);
            if let Some(&(other, their_hits)) = theirs.as_ref().and_then(|t| t.get(i)) {
                ratios[i].push(rate / other);
                // Theirs may miss a ray at an edge.
                assert!(hits.abs_diff(their_hits) <= 1 + hits / 1000, "{}: {hits} and {their_hits}", NAMES[i]);
            }
        }
    }
    println!("{:<18} {:>8} {:>7} {:>6}", "", "Mrays/s", "ratio", "bound");
    let median = |v: &mut Vec<f64>| {
        v.sort_by(f64::total_cmp);
        v.get(v.len() / 2).copied().unwrap_or(f64::NAN)
    };
    for i in 0..6 {
        let bound = if name == "mesh" { 0.7 } else { f64::NAN };
        println!("{:<18} {:>8.2} {:>7.2} {bound:>6}", NAMES[i], median(&mut ours[i]), median(&mut ratios[i]));
    }
    Ok(())
}

/// The best of three, and how many rays met something.
fn rate(geometry: &Geometry, rays: &Rays, any: bool) -> (f64, usize) {
    let (mut best, mut hits) = (0f64, 0);
    for _ in 0..3 {
        let start = Instant::now();
        hits = if any {
            rays.iter().filter(|(o, d)| !geometry.unoccluded(*o, *d)).count()
        } else {
            rays.iter().filter(|(o, d)| geometry.closest(*o, *d).is_some_and(|h| h.t > 0.0)).count()
        };
        best = best.max(rays.len() as f64 / start.elapsed().as_secs_f64() * 1e-6);
    }
    (best, hits)
}

fn embree(program: &str, file: &Path) -> Option<Vec<(f64, usize)>> {
    let output = Command::new(program).arg(file).output().ok().filter(|o| o.status.success())?;
    let line = |l: &str| {
        let mut words = l.split(' ');
        Some((words.next()?.parse().ok()?, words.next()?.parse().ok()?))
    };
    String::from_utf8(output.stdout).ok()?.lines().map(line).collect()
}

fn write(path: &Path, triangles: &[[Vec3A; 3]], sets: &[Rays; 3]) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    let vector = |out: &mut dyn Write, v: Vec3A| v.to_array().iter().try_for_each(|x| out.write_all(&x.to_ne_bytes()));
    out.write_all(&(triangles.len() as u32).to_ne_bytes())?;
    for corner in triangles.iter().flatten() {
        vector(&mut out, *corner)?;
    }
    for (rays, any) in sets.iter().flat_map(|s| [(s, 0u32), (s, 1)]) {
        out.write_all(&(rays.len() as u32).to_ne_bytes())?;
        out.write_all(&any.to_ne_bytes())?;
        for (origin, direction) in rays {
            vector(&mut out, *origin)?;
            vector(&mut out, *direction)?;
        }
    }
    out.flush()
}

/// Numbers in 0..1 that repeat.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Primary, diffuse and shuffled rays.
fn rays(geometry: &Geometry, [eye, target]: [Vec3A; 2], width: usize) -> [Rays; 3] {
    let mut random = Random(1);
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3A::Y).normalize();
    let up = right.cross(forward);
    let reach = 19f32.to_radians().tan();
    let (mut primary, mut diffuse) = (Vec::new(), Vec::new());
    for i in 0..width * width {
        let mut place = |k: usize| ((k as f64 + random.unit()) / width as f64 * 2.0 - 1.0) as f32 * reach;
        let (x, y) = (place(i % width), -place(i / width));
        let direction = (forward + right * x + up * y).normalize();
        primary.push((eye, direction));
        if let Some(hit) = geometry.closest(eye, direction) {
            let normal = if hit.normal.dot(direction) > 0.0 { -hit.normal } else { hit.normal };
            let u = [random.unit() as f32, random.unit() as f32];
            diffuse.push((offset(hit.point, normal, hit.reach), cosine_direction(normal, u)));
        }
    }
    let mut shuffled = diffuse.clone();
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, (random.unit() * (i + 1) as f64) as usize);
    }
    [primary, diffuse, shuffled]
}

fn split(primitive: &Primitive) -> Vec<[Vec3A; 3]> {
    match *primitive {
        Primitive::Triangle(corners) => vec![corners],
        Primitive::Parallelogram { corner, u, v } => {
            vec![[corner, corner + u, corner + u + v], [corner, corner + u + v, corner + v]]
        }
        _ => Vec::new(),
    }
}

/// n x n cells of two triangles under 16 waves, from -5 to 5.
fn height_field(n: usize, random: &mut Random) -> Vec<Primitive> {
    let waves: [[f64; 4]; 16] = std::array::from_fn(|_| {
        [
            random.within(0.02, 0.1),
            random.within(-3.0, 3.0),
            random.within(-3.0, 3.0),
            random.within(0.0, std::f64::consts::TAU),
        ]
    });
    let point = |i: usize, j: usize| {
        let (x, z) = (-5.0 + 10.0 * i as f64 / n as f64, -5.0 + 10.0 * j as f64 / n as f64);
        let y: f64 = waves.iter().map(|[a, fx, fz, p]| a * (fx * x + fz * z + p).sin()).sum();
        vec3a(x as f32, y as f32, z as f32)
    };
    let cell = |i: usize, j: usize| [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
    let cells = (0..n * n).map(|k| cell(k % n, k / n));
    cells.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).map(Primitive::Triangle).collect()
}

/// A sphere of 128 x 64 cells with six waves on its radius.
fn displaced_sphere(centre: [f64; 3], radius: f64, random: &mut Random) -> Vec<Primitive> {
    let (nu, nv) = (128, 64);
    let waves: [[f64; 4]; 6] = std::array::from_fn(|_| {
        let (m, l) = (random.within(3.0, 12.0).floor(), random.within(4.0, 12.0).floor());
        [random.within(0.01, 0.05), m, l, random.within(0.0, std::f64::consts::TAU)]
    });
    let point = |i: usize, j: usize| {
        let (theta, phi) =
            (std::f64::consts::PI * j as f64 / nv as f64, std::f64::consts::TAU * (i % nu) as f64 / nu as f64);
        let (s, c) = theta.sin_cos();
        let wave: f64 = waves.iter().map(|[a, m, l, p]| a * (m * phi + p).sin() * s * (l * theta).sin()).sum();
        let r = radius * (1.0 + wave);
        let at = [r * s * phi.cos(), r * c, r * s * phi.sin()];
        Vec3A::from_array(std::array::from_fn(|k| (centre[k] + at[k]) as f32))
    };
    let mut all = Vec::new();
    for (i, j) in (0..nu * nv).map(|k| (k % nu, k / nu)) {
        let (a, b, c, d) = (point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1));
        if j > 0 {
            all.push(Primitive::Triangle([a, b, c]));
        }
        if j + 1 < nv {
            all.push(Primitive::Triangle([a, c, d]));
        }
    }
    all
}

fn parallelogram(corner: [f32; 3], a: [f32; 3], b: [f32; 3]) -> Primitive {
    let corner = Vec3A::from_array(corner);
    Primitive::Parallelogram { corner, u: Vec3A::from_array(a) - corner, v: Vec3A::from_array(b) - corner }
}

/// A height field and five displaced spheres, all triangles, in a room open to the front.
fn room() -> Vec<Primitive> {
    let mut random = Random(7);
    let mut all = height_field(256, &mut random);
    let spheres = [
        ([-2.8, 2.0, -1.5], 1.03),
        ([0.2, 2.4, 1.8], 1.19),
        ([2.9, 1.9, -0.8], 0.98),
        ([-1.2, 4.6, 2.6], 1.09),
        ([1.6, 5.0, 0.4], 1.14),
    ];
    for (centre, radius) in spheres {
        all.extend(displaced_sphere(centre, radius, &mut random));
    }
    let walls = [
        parallelogram([-5.0, 8.0, -5.0], [5.0, 8.0, -5.0], [-5.0, 8.0, 5.0]),
        parallelogram([-5.0, -2.0, 5.0], [5.0, -2.0, 5.0], [-5.0, 8.0, 5.0]),
        parallelogram([-5.0, -2.0, -5.0], [-5.0, -2.0, 5.0], [-5.0, 8.0, -5.0]),
        parallelogram([5.0, -2.0, -5.0], [5.0, -2.0, 5.0], [5.0, 8.0, -5.0]),
        parallelogram([-1.5, 7.9, -1.5], [1.5, 7.9, -1.5], [-1.5, 7.9, 1.5]),
    ];
    all.extend(walls.iter().flat_map(split).map(Primitive::Triangle));
    all
}

/// The Cornell box with right angles: walls, lamp, and two blocks turned about the vertical.
fn cornell() -> Vec<Primitive> {
    let (w, h, d) = (556.0, 548.8, 559.2);
    let mut all = vec![
        parallelogram([0.0, 0.0, 0.0], [w, 0.0, 0.0], [0.0, 0.0, d]),
        parallelogram([0.0, h, 0.0], [w, h, 0.0], [0.0, h, d]),
        parallelogram([0.0, 0.0, d], [w, 0.0, d], [0.0, h, d]),
        parallelogram([0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, 0.0, d]),
        parallelogram([w, 0.0, 0.0], [w, h, 0.0], [w, 0.0, d]),
        parallelogram([213.0, h - 0.5, 227.0], [343.0, h - 0.5, 227.0], [213.0, h - 0.5, 332.0]),
    ];
    for (corner, u, v, height) in [
        (vec3a(130.0, 0.0, 65.0), vec3a(-48.0, 0.0, 160.0), vec3a(160.0, 0.0, 49.0), 165.0),
        (vec3a(423.0, 0.0, 247.0), vec3a(-158.0, 0.0, 49.0), vec3a(49.0, 0.0, 159.0), 330.0),
    ] {
        let up = Vec3A::Y * height;
        let sides = [
            (corner, u, v),
            (corner + up, u, v),
            (corner, u, up),
            (corner, v, up),
            (corner + u, v, up),
            (corner + v, u, up),
        ];
        all.extend(sides.map(|(corner, u, v)| Primitive::Parallelogram { corner, u, v }));
    }
    all.iter().map(in_frame).collect()
}

/// Where the box's millimetres lie in the numbers that rays are traced in.
fn framed(place: Vec3A) -> Vec3A {
    (place - Vec3A::splat(MIDDLE)) / MIDDLE
}

fn in_frame(primitive: &Primitive) -> Primitive {
    match *primitive {
        Primitive::Parallelogram { corner, u, v } => {
            Primitive::Parallelogram { corner: framed(corner), u: u / MIDDLE, v: v / MIDDLE }
        }
        other => other,
    }
}
