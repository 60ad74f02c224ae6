//! The resolution line: `-Y 480 +X 640` and its seven sisters.

use std::fmt;

use crate::{Result, invalid};

/// Largest width or height: sizes of 2^31 and more are damage.
const LARGEST: u64 = i32::MAX as u64;

/// Size and scan order. Scanlines run along the minor axis; `-Y n +X m` is the usual top-down, left-to-right picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Pixels across the upright picture.
    pub width: usize,
    /// Pixels down the upright picture.
    pub height: usize,
    /// Scanlines are rows of the upright picture (Y comes first on the line).
    pub by_rows: bool,
    /// The first scanline or pixel lies at the right (`-X`).
    pub from_right: bool,
    /// The first scanline or pixel lies at the bottom (`+Y`).
    pub from_bottom: bool,
}

impl Resolution {
    /// `-Y height +X width`
    pub fn upright(width: usize, height: usize) -> Resolution {
        Resolution { width, height, by_rows: true, from_right: false, from_bottom: false }
    }

    /// Number of scanlines.
    pub fn scanlines(&self) -> usize {
        if self.by_rows { self.height } else { self.width }
    }

    /// The same scan order with so many scanlines.
    pub fn with_scanlines(self, scanlines: usize) -> Resolution {
        if self.by_rows { Resolution { height: scanlines, ..self } } else { Resolution { width: scanlines, ..self } }
    }

    /// Pixels a scanline.
    pub fn scanline_len(&self) -> usize {
        if self.by_rows { self.width } else { self.height }
    }

    /// Parses a line without its newline, strictly: no sign on the number, no fraction, 1 to 2^31 - 1.
    ///
    /// ```
    /// use luxpipe::stream::Resolution;
    /// let r = Resolution::parse(b"-Y      480 +X      640").unwrap();
    /// assert_eq!((r.width, r.height, r.to_string().as_str()), (640, 480, "-Y      480 +X      640"));
    /// assert!(Resolution::parse(b"-Y 48.5 +X 64").is_err());
    /// assert!(Resolution::parse(b"-Y 48 +X 4294967360").is_err());
    /// ```
    pub fn parse(line: &[u8]) -> Result<Resolution> {
        let shown = crate::error::printable(line);
        let wrong = |why: &str| invalid!("resolution line '{shown}': {why}; expected for instance '-Y 480 +X 640'");
        let Ok(text) = std::str::from_utf8(line) else { return wrong("not text") };
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let [axis1, n1, axis2, n2] = words[..] else { return wrong("not two axes and two sizes") };
        let by_rows = match (axis1, axis2) {
            ("-Y" | "+Y", "-X" | "+X") => true,
            ("-X" | "+X", "-Y" | "+Y") => false,
            _ => return wrong("unknown axes"),
        };
        let mut size = [0usize; 2];
        for (n, out) in [n1, n2].into_iter().zip(&mut size) {
            let digits = n.len() <= 19 && n.bytes().all(|b| b.is_ascii_digit());
            match n.parse::<u64>() {
                Ok(v) if digits && (1..=LARGEST).contains(&v) => *out = v as usize,
                _ => return wrong(&format!("size '{n}' is not a whole number from 1 to {LARGEST}")),
            }
        }
        let (width, height) = if by_rows { (size[1], size[0]) } else { (size[0], size[1]) };
        Ok(Resolution {
            width,
            height,
            by_rows,
            from_right: axis1 == "-X" || axis2 == "-X",
            from_bottom: axis1 == "+Y" || axis2 == "+Y",
        })
    }
}

impl fmt::Display for Resolution {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let x = if self.from_right { "-X" } else { "+X" };
        let y = if self.from_bottom { "+Y" } else { "-Y" };
        if self.by_rows {
            write!(f, "{y} {:8} {x} {:8}", self.height, self.width)
        } else {
            write!(f, "{x} {:8} {y} {:8}", self.width, self.height)
        }
    }
}
