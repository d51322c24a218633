//! LZF decompression: literal runs of 1 to 32 bytes, copies of 3 to 264 bytes from at most 8192 bytes back.
//!
//! Source: Marc Lehmann's liblzf, whose stream PCL writes.

use std::vec::Vec;

/// A copy of 264 bytes takes 3: no stream makes more of a byte.
const MAX_GROWTH: usize = 264 / 3;

/// A stream that no compressor makes: the byte of it that shows so.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Broken {
    pub(super) offset: usize,
}

/// Decompresses a stream that must give exactly `len` bytes. Takes at most 88 times the input's length in memory.
pub(super) fn decompress(input: &[u8], len: usize) -> Result<Vec<u8>, Broken> {
    if len > input.len().saturating_mul(MAX_GROWTH) {
        return Err(Broken { offset: input.len() });
    }
    let mut stream = Stream { input, offset: 0, output: Vec::with_capacity(len), len };
    while stream.offset < input.len() {
        stream.step()?;
    }
    if stream.output.len() == len { Ok(stream.output) } else { Err(stream.broken()) }
}

struct Stream<'a> {
    input: &'a [u8],
    offset: usize,
    output: Vec<u8>,
    /// Bytes the output must have in the end.
    len: usize,
}

impl Stream<'_> {
    fn broken(&self) -> Broken {
        Broken { offset: self.offset }
    }

    fn byte(&mut self) -> Result<usize, Broken> {
        let byte = *self.input.get(self.offset).ok_or_else(|| self.broken())?;
        self.offset += 1;
        Ok(usize::from(byte))
    }

    /// One instruction: `000nnnnn`, n + 1 literals follow; `lllooooo` and `111ooooo l` with one more byte of the
    /// distance: copy.
    fn step(&mut self) -> Result<(), Broken> {
        let control = self.byte()?;
        match control >> 5 {
            0 => self.literals(control + 1),
            7 => {
                let copy_len = 7 + self.byte()? + 2;
                self.copy(copy_len, control)
            }
            short => self.copy(short + 2, control),
        }
    }

    fn literals(&mut self, count: usize) -> Result<(), Broken> {
        self.check_room(count)?;
        let literals = self.input.get(self.offset..self.offset + count).ok_or_else(|| self.broken())?;
        self.output.extend_from_slice(literals);
        self.offset += count;
        Ok(())
    }

    fn copy(&mut self, count: usize, control: usize) -> Result<(), Broken> {
        let distance = ((control & 0x1f) << 8) + self.byte()? + 1;
        self.check_room(count)?;
        let from = self.output.len().checked_sub(distance).ok_or_else(|| self.broken())?;
        for index in from..from + count {
            // Byte by byte: a copy may reach into itself.
            self.output.push(self.output[index]);
        }
        Ok(())
    }

    fn check_room(&self, count: usize) -> Result<(), Broken> {
        if self.output.len() + count <= self.len { Ok(()) } else { Err(self.broken()) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Broken, decompress};

    #[test]
    fn literals_and_copies() {
        assert_eq!(decompress(&[2, b'a', b'b', b'c'], 3).unwrap(), b"abc");
        assert_eq!(decompress(&[1, b'a', b'b', 0x20, 1], 5).unwrap(), b"ababa");
        assert_eq!(decompress(&[0, b'a', 0xe0, 255, 0], 265).unwrap(), [b'a'; 265]);
        assert_eq!(decompress(&[], 0).unwrap(), b"");
    }

    #[test]
    fn broken_streams_say_where() {
        let at = |offset| Err(Broken { offset });
        assert_eq!(decompress(&[2, b'a', b'b'], 3), at(1)); // literals end early
        assert_eq!(decompress(&[0, b'a', 0x20], 4), at(3)); // no distance
        assert_eq!(decompress(&[0, b'a', 0xe0, 1], 11), at(4)); // the same after a long length
        assert_eq!(decompress(&[0, b'a', 0x20, 1], 4), at(4)); // from before the start
        assert_eq!(decompress(&[1, b'a', b'b'], 1), at(1)); // more than there should be
        assert_eq!(decompress(&[1, b'a', b'b'], 3), at(3)); // less
        assert_eq!(decompress(&[0, b'a'], usize::MAX), at(2)); // an absurd length allocates nothing
    }
}
