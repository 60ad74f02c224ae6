//! The filters that write the encodings, on a picture: bytes a pixel, and speed.

#[path = "../../benches/picture/mod.rs"]
mod picture;

use std::path::Path;
use std::time::Instant;

use luxpipe::codec::{self, Reading};
use luxpipe::filter::{self, Filter, Stage};
use luxpipe::filters::{RaExr, RaLoglv, RaPixlog, RaRgbe};
use luxpipe::notes::Notes;
use luxpipe::options::RunOptions;
use luxpipe::parallel;
use luxpipe::stream::meaning::Overrides;
use luxpipe::stream::picture::block_rows;
use luxpipe::stream::reader::Input;
use luxpipe::stream::{Block, Components, Header, Picture, Resolution, Units};
use luxpipe::{Result, stream};

use super::coders::{ENCODINGS, Encoding};

/// Size of the picture.
const SIZE: [usize; 2] = [2048, 1024];
/// Runs of which the median counts.
const RUNS: usize = 5;

/// A picture in memory, handed on as often as it is asked for.
#[derive(Clone)]
pub struct Memory {
    /// What it is.
    pub header: Header,
    /// All its components.
    pub data: Vec<f32>,
    row: usize,
}

impl Memory {
    /// From its pixels.
    pub fn new(header: Header, data: Vec<f32>) -> Memory {
        Memory { header, data, row: 0 }
    }
}

impl Picture for Memory {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let width = self.header.scanline_floats();
        let left = self.data.len() / width - self.row;
        block.rows = block_rows(&self.header, left).min(left);
        block.data.clear();
        block.data.extend_from_slice(&self.data[self.row * width..][..block.rows * width]);
        self.row += block.rows;
        Ok(block.rows > 0)
    }

    fn rewind(&mut self) -> Result<bool> {
        self.row = 0;
        Ok(true)
    }
}

/// Records a picture by a filter's command line; what the filter remarks.
pub fn record(command: &str, picture: Memory, path: &Path) -> Result<Vec<String>> {
    let words: Vec<&str> = command.split(' ').chain(["-", path.to_str().expect("a name in UTF-8")]).collect();
    let stage = match words[0] {
        RaRgbe::NAME => stage::<RaRgbe>(&words),
        RaLoglv::NAME => stage::<RaLoglv>(&words),
        RaPixlog::NAME => stage::<RaPixlog>(&words),
        _ => stage::<RaExr>(&words),
    };
    let notes = Notes::default();
    stage.run(Some(Box::new(picture)), &notes)?;
    Ok(notes.take())
}

fn stage<F: Filter>(words: &[&str]) -> Stage {
    let matches = filter::command::<F>().try_get_matches_from(words).expect("options of the filter");
    Stage::from_matches::<F>(&matches).expect("options of the filter")
}

/// Opens any picture.
pub fn open(path: &Path) -> Result<Box<dyn Picture>> {
    let (overrides, limits) = (Overrides::default(), RunOptions::default().limits());
    let reading = Reading { overrides: &overrides, limits: &limits, notes: &Notes::default() };
    codec::open(Input::open(Some(path))?, &reading)
}

/// Reads it all.
pub fn read(mut picture: Box<dyn Picture>) -> Result<Memory> {
    let (mut block, mut data) = (Block::default(), Vec::new());
    while picture.next(&mut block)? {
        data.extend_from_slice(&block.data);
    }
    Ok(Memory::new(picture.header().clone(), data))
}

/// XYZ of any picture.
pub fn read_xyz(path: &Path) -> Result<Vec<f32>> {
    Ok(read(stream::tristimulus::tristimulus(open(path)?)?)?.data)
}

/// A folder in memory where there is one.
pub fn folder() -> tempfile::TempDir {
    let ram = Path::new("/dev/shm");
    let made = if ram.is_dir() { tempfile::tempdir_in(ram) } else { tempfile::tempdir() };
    made.expect("a folder")
}

/// The picture that bytes and speed are measured on.
pub fn picture(folder: &Path) -> Memory {
    let path = folder.join("picture.lux");
    picture::write(&path, SIZE[0], SIZE[1]).expect("room for a picture");
    read(open(&path).expect("a picture")).expect("a picture")
}

/// The Cornell box in XYZ, with the noise of a renderer (tests/ref/README.md); its unit is taken as 100 cd/m2.
fn cornell() -> Memory {
    let bytes = include_bytes!("../../tests/ref/a_cornell_xyz.npy");
    let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let floats = bytes[head..].chunks_exact(4).map(|b| 100.0 * f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    Memory::new(Header::new(Resolution::upright(128, 128), Components::Xyz, 3, Units::CdM2), floats.collect())
}

/// Bytes a pixel of each encoding's files: of the picture for speed, and of the Cornell box.
pub fn bytes_a_pixel() -> Vec<[f64; 2]> {
    let dir = folder();
    let path = dir.path().join("out");
    let pictures = [picture(dir.path()), cornell()];
    let size = |command: &str, picture: &Memory| {
        record(command, picture.clone(), &path).expect("a picture that fits");
        path.metadata().expect("a file").len() as f64 / (picture.data.len() / 3) as f64
    };
    ENCODINGS.iter().map(|e| pictures.each_ref().map(|p| size(e.command, p))).collect()
}

/// Megapixels a second on one thread: writing from XYZ in memory, reading to floats.
pub fn speeds() -> Vec<[f64; 2]> {
    parallel::set_threads(1);
    let dir = folder();
    let picture = picture(dir.path());
    let path = dir.path().join("out");
    let speed = |e: &Encoding| {
        let mut seconds = [Vec::new(), Vec::new()];
        for _ in 0..RUNS {
            let copy = picture.clone();
            let start = Instant::now();
            record(e.command, copy, &path).expect("a picture that fits");
            seconds[0].push(start.elapsed().as_secs_f64());
            let (start, mut block) = (Instant::now(), Block::default());
            let mut read = open(&path).expect("a picture");
            while read.next(&mut block).expect("a picture") {}
            seconds[1].push(start.elapsed().as_secs_f64());
        }
        seconds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            (SIZE[0] * SIZE[1]) as f64 / 1e6 / times[RUNS / 2]
        })
    };
    ENCODINGS.iter().map(speed).collect()
}

/// What the processor calls itself.
pub fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find_map(|l| l.strip_prefix("model name")).unwrap_or("an unknown processor");
    name.trim_start_matches([' ', '\t', ':']).to_string()
}
