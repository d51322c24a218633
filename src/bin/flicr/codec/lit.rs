//! Intensities along with a scan.

use flicr::coder::Coder;
use flicr::files::PointCloud;
use flicr::plane::{IntensityCoder, IntensityPlane, IntensityScale, Planes, TimesPlane};
use flicr::{EncodeError, Encoded, FrameEncoder, FrameSettings, GridReturn, Level, Previous};

/// How finely intensities are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    Lossless,
    /// In steps of so many of their 8-bit numbers.
    Step(u8),
}

/// `lossless`, or a step.
pub fn keep(text: &str) -> Result<Keep, String> {
    if text == "lossless" {
        return Ok(Keep::Lossless);
    }
    let step = text.parse().ok().filter(|&step| step > 0);
    step.map(Keep::Step).ok_or_else(|| "expected lossless or a step from 1 to 255".to_owned())
}

/// As many rows as context coders can have; classes for the 64 of most sensors.
type MostRows = IntensityCoder<1024, 64>;

/// Memory for a scan's intensities.
pub struct Lit {
    keep: Keep,
    scale: IntensityScale,
    /// Of the points, or the returns of a turn, which are as many.
    numbers: Vec<u8>,
    plane: Vec<u8>,
    coder: Box<MostRows>,
}

/// A scan's intensities and where they go.
pub struct LitScan<'a> {
    pub numbers: &'a [u8],
    pub plane: &'a mut [u8],
    scale: IntensityScale,
    coder: &'a mut MostRows,
}

impl Lit {
    pub fn new(keep: Keep) -> Self {
        let coder = Box::new(MostRows::new());
        Self { keep, scale: IntensityScale::RAW, numbers: Vec::new(), plane: Vec::new(), coder }
    }

    /// Makes ready for a scan of so many pixels; gives the bytes by which a frame can get longer.
    pub fn prepare(&mut self, cloud: &PointCloud, pixels: usize, strips: usize) -> Result<usize, String> {
        let intensities = cloud.intensities.as_deref().ok_or("found no intensities, asked to keep them")?;
        self.scale = self.keep.scale(intensities)?;
        self.numbers.clear();
        self.numbers.extend(intensities.iter().map(|&intensity| self.scale.nearest(intensity)));
        self.plane.resize(pixels, 0);
        Ok(IntensityPlane::worst_case_len(pixels, strips))
    }

    pub fn scan(&mut self) -> LitScan<'_> {
        let Self { scale, numbers, plane, coder, .. } = self;
        LitScan { numbers, plane, scale: *scale, coder }
    }
}

impl Keep {
    fn scale(self, intensities: &[f32]) -> Result<IntensityScale, String> {
        let exact = IntensityScale::recognize(intensities);
        match self {
            Self::Lossless => exact.ok_or_else(|| {
                "intensities are not numbers of 8 bits (hundredths, 255ths, 256ths or whole): expected a step, --intensity 1".to_owned()
            }),
            Self::Step(step) => {
                let most = intensities.iter().copied().filter(|i| i.is_finite()).fold(0.0, f32::max);
                let per_unit = exact.map_or(if most > 0.0 { 255.0 / most } else { 1.0 }, IntensityScale::per_unit);
                IntensityScale::new(per_unit, step).ok_or_else(|| format!("intensities up to {most}: found none to scale by"))
            }
        }
    }
}

impl LitScan<'_> {
    /// Returns with their intensities.
    pub fn returns<'r>(numbers: &'r [u8], returns: &'r [GridReturn]) -> impl Iterator<Item = (GridReturn, u8)> {
        returns.iter().copied().zip(numbers.iter().copied())
    }

    /// Codes the frame, with intensities where there are any.
    pub fn finish<L: Level, C: Coder<L>, S: FrameSettings>(
        lit: Option<Self>,
        times: Option<TimesPlane<'_>>,
        previous: Option<&mut Previous<Vec<u16>>>,
        frame: FrameEncoder<'_, L, C, S>,
        out: &mut [u8],
    ) -> Result<Encoded, EncodeError> {
        let intensity = lit.map(|Self { plane, scale, coder, .. }| coder.plane(plane, scale));
        let planes = Planes { intensity, times };
        match previous {
            Some(previous) => frame.finish_after(previous, planes, out),
            None => frame.finish_with(planes, out),
        }
    }
}
