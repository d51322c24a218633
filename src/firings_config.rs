//! What a frame with a column a firing is to be like.

use crate::config::{FrameSettings, LatticeConfig, Scale, beams_worst_case_len, check_image};
use crate::error::ConfigError;
use crate::fit::GridFit;
use crate::frame::{BeamsHeader, FiringsHeader};
use crate::geometry::{FiringLattice, Firings, Projection, bitmap_len};
use crate::insert::Policy;
use crate::point::Points;
use crate::quantize::{Companding, Quantizer};

/// A frame on the sensor's own grid with a column for each firing of this turn: every return comes back on its beam and
/// tick. The image must have a row for each beam and a column for each firing.
///
/// ```
/// use flicr::geometry::{Firings, Lattice, sensors::hdl64e};
/// use flicr::{Encoder, FiringsConfig, LatticeConfig, Rle, Stamp};
/// let firings: Firings<125> = Firings::new(4000, (0..4000).step_by(2))?;
/// let lattice = Lattice::<66>::new(hdl64e::FIRING_GRID, 4000)?;
/// let config = FiringsConfig { every_tick: LatticeConfig::new(&lattice), firings: &firings };
/// let mut encoder: Encoder<64, 2000, u16, Rle> = Encoder::new(Rle::new());
/// let mut out = vec![0; config.worst_case_len::<u16, Rle>()];
/// let encoded = encoder.encode(&config, [[10.0_f32, 0.0, -1.0]].as_slice(), Stamp::default(), &mut out)?;
/// assert_eq!(encoded.tally.kept(), 1);
/// # Ok::<(), flicr::EncodeError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct FiringsConfig<'a, const LINES: usize, const WORDS: usize, const NODES: usize = 257> {
    /// Everything else, with a lattice that has a column for every tick.
    pub every_tick: LatticeConfig<'a, LINES, NODES>,
    /// The ticks that the sensor fired at.
    pub firings: &'a Firings<WORDS>,
}

impl<const LINES: usize, const WORDS: usize, const NODES: usize> FiringsConfig<'_, LINES, WORDS, NODES> {
    /// Output bytes that are enough for every frame with as many firings.
    #[must_use]
    pub const fn worst_case_len<L: crate::image::Level, C: crate::coder::Coder<L>>(&self) -> usize {
        let LatticeConfig { lattice, table, strips, .. } = self.every_tick;
        let (rows, columns) = (lattice.grid().beams.len(), self.firings.len() as usize);
        let len = beams_worst_case_len::<L, C>(rows, columns, strips, table);
        len + bitmap_len(self.firings.ticks())
    }
}

impl<'a, const LINES: usize, const WORDS: usize, const NODES: usize> FrameSettings
    for FiringsConfig<'a, LINES, WORDS, NODES>
{
    type Projection = FiringLattice<'a, LINES, WORDS, NODES>;
    type Fit = GridFit;
    type Fields = FiringsHeader<'a, WORDS>;

    fn projection(&self, rows: usize, columns: usize) -> Result<Self::Projection, ConfigError> {
        let lattice = FiringLattice::new(self.every_tick.lattice, self.firings)?;
        check_image((rows, columns), (lattice.rows(), lattice.columns()))?;
        Ok(lattice)
    }

    fn levels(&self) -> (u32, Scale, Companding) {
        self.every_tick.levels()
    }

    fn policy(&self) -> Policy {
        self.every_tick.policy
    }

    fn strips(&self) -> u16 {
        self.every_tick.strips
    }

    fn for_each_firing(&self, each: &mut dyn FnMut(u32)) {
        self.firings.iter().for_each(each);
    }

    fn fields(&self, fit: &GridFit) -> FiringsHeader<'a, WORDS> {
        let beams: BeamsHeader<'a> = self.every_tick.fields(fit);
        FiringsHeader { beams, firings: self.firings }
    }

    fn measure(&self, points: &(impl Points + ?Sized), quantizer: &Quantizer, fit: &mut GridFit) {
        let every_tick = &self.every_tick;
        if !every_tick.measure {
            return;
        }
        // It was made before, or there would be no frame.
        let Ok(lattice) = FiringLattice::new(every_tick.lattice, self.firings) else { return };
        points.for_each_block(|block, len| {
            let ticks_off = lattice.ticks_off(block, quantizer);
            for (i, &off) in ticks_off.iter().enumerate().take(len) {
                let point = [block.x[i], block.y[i], block.z[i]];
                fit.add_beside(every_tick.lattice, quantizer, point, off);
            }
        });
    }
}
