//! The picture that encodings are measured on: smooth where a real one is, with 2 % noise, edges, lamps and black pixels, over
//! seven orders of magnitude.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes XYZ of that size as a float stream, the same at every run.
pub fn write(path: &Path, width: usize, height: usize) -> std::io::Result<()> {
    let lines = "#?RADIANCE\nNCOMP=3\nCOMPONENTS=XYZ\nUNITS=cd/m2\nWHITE= 0.3127 0.329\nBigEndian=0\nFORMAT=float";
    let mut out = BufWriter::new(File::create(path)?);
    write!(out, "{lines}\n\n-Y {height:8} +X {width:8}\n")?;
    let mut state = 1u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let lamps: Vec<[f32; 4]> = (0..40)
        .map(|_| [random(), 0.1 + 0.6 * random(), 1.0 / (0.001 + 0.005 * random()), 10f32.powf(2.5 + 1.5 * random())])
        .collect();
    let tones: Vec<f32> = (0..12 * 24).map(|_| 1.8 * random() - 0.9).collect();
    for row in 0..height {
        let y = row as f32 / height as f32;
        for column in 0..width {
            let x = column as f32 / width as f32;
            let base =
                2.2 * (4.0 * (x - 0.55)).tanh() + 0.5 * (9.0 * x + 3.0 * y).sin() + 0.3 * (31.0 * y - 11.0 * x).sin();
            let tone = tones[(y * 12.0) as usize * 24 + (x * 24.0) as usize];
            let mut l = 10f32.powf((base - 1.0 + tone).clamp(-3.0, 3.0));
            for [cx, cy, size, peak] in &lamps {
                let d = ((x - cx) * 2.0).hypot(y - cy) * size;
                if d < 4.0 {
                    l += peak * (-d * d).exp();
                }
            }
            let noise = random() + random() + random() - 1.5; // variance 1/4
            l *= (0.04 * noise).exp();
            if random() < 0.0005 {
                l = 0.0;
            }
            let (cx, cy) = (0.3127 + 0.12 * (5.0 * x + 2.0 * y).sin(), 0.329 + 0.1 * (4.0 * y - 3.0 * x).sin());
            for value in [l * cx / cy, l, l * (1.0 - cx - cy) / cy] {
                out.write_all(&value.to_ne_bytes())?;
            }
        }
    }
    out.flush()
}
