//! PNG files as tests see them.

pub struct Picture {
    pub width: usize,
    pub rgb: Vec<[u8; 3]>,
}

impl Picture {
    pub fn of(png: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        Self { width: info.width as usize, rgb: pixels.as_chunks().0.to_vec() }
    }

    /// Share of the pixels of a column range and row range that have a color, rather than being black or gray.
    pub fn colored(&self, x: std::ops::Range<usize>, y: std::ops::Range<usize>) -> f64 {
        let all = y.flat_map(|y| x.clone().map(move |x| (x, y))).map(|(x, y)| self.rgb[y * self.width + x]);
        let colors: Vec<bool> = all.map(|[r, g, b]| r.abs_diff(g).max(g.abs_diff(b)) > 20).collect();
        colors.iter().filter(|&&color| color).count() as f64 / colors.len() as f64
    }

    pub fn height(&self) -> usize {
        self.rgb.len() / self.width
    }
}
