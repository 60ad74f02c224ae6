//! Mitsuba's `.vol` files of dense voxels: `VOL`, a byte 3; then little endian the encoding (i32, 1: f32), the numbers of voxels along
//! x, y and z and of channels (i32, one channel is read), a box (six f32: its low corner, then its high one), and the values (f32, x
//! first). Values are finite and not below 0.

use std::io::{BufReader, Read};
use std::path::Path;

use crate::{Error, Result, invalid};

/// Voxels at most: 4 GB of them.
const MOST_VOXELS: u64 = 1 << 30;

/// Voxels of a box.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// How many along x, y and z.
    pub size: [usize; 3],
    /// Corner of the box.
    pub low: [f64; 3],
    /// The opposite corner.
    pub high: [f64; 3],
    /// x first.
    pub values: Vec<f32>,
}

/// Densities beyond this leave floats along a way.
const DENSEST: f32 = 1e12;

/// Reads a file.
pub fn read(path: &Path) -> Result<Volume> {
    let file = crate::files::open(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    parse(&mut BufReader::new(file)).map_err(|e| e.in_file(path))
}

/// Reads voxels from bytes.
pub fn parse(source: &mut impl Read) -> Result<Volume> {
    let mut head = [0u8; 48];
    source.read_exact(&mut head).map_err(|_| Error::Invalid("ends within the header of a volume".into()))?;
    let word = |i: usize| i32::from_le_bytes([head[i], head[i + 1], head[i + 2], head[i + 3]]);
    let real = |i: usize| f64::from(f32::from_bits(word(i) as u32));
    if &head[..3] != b"VOL" || head[3] != 3 {
        return invalid!("is no volume: expected 'VOL' and version 3");
    }
    if word(4) != 1 || word(20) != 1 {
        return invalid!("encoding {} with {} channels; one channel of f32 (encoding 1) is read", word(4), word(20));
    }
    let size = [word(8), word(12), word(16)];
    let count = size.iter().try_fold(1u64, |n, s| n.checked_mul(u64::try_from(*s).ok()?)).unwrap_or(0);
    if count == 0 || count > MOST_VOXELS {
        return invalid!("{} x {} x {} voxels; there must be some, {MOST_VOXELS} at most", size[0], size[1], size[2]);
    }
    // Grown as they come: a header alone must not take the memory.
    let mut values = Vec::new();
    let mut some = vec![0u8; (4 * count).min(1 << 16) as usize];
    while (values.len() as u64) < count {
        let left = (4 * (count - values.len() as u64)).min(some.len() as u64) as usize;
        if source.read_exact(&mut some[..left]).is_err() {
            let row = values.len() as u64 / size[0] as u64;
            return invalid!("ends in row {row} of {} of its voxels", count / size[0] as u64);
        }
        values.extend(some[..left].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)));
    }
    if let Some(i) = values.iter().position(|v| !(*v >= 0.0 && *v <= DENSEST)) {
        return invalid!("voxel {i} is {}; densities are 0 to {DENSEST:e}", values[i]);
    }
    let corner = |i: usize| [real(i), real(i + 4), real(i + 8)];
    Ok(Volume { size: size.map(|n| n as usize), low: corner(24), high: corner(36), values })
}
