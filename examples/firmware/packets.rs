//! A sensor's packets to frames: no coordinate is ever made.

use flicr::geometry::sensors::{hesai, velodyne};
use flicr::geometry::{Beam, SensorGrid};
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::{EncodedTurn, GridConfig, ImageViewMut, PacketEncoder, PushError, Rle, Scale};
use semihosting::io::Write;

use super::host::{PIECE_LEN, Packets, create_frames, print_line};
use super::job::{CoderName, Even, Job, Usage};
use super::stage::{Board, Clock, Stage};
use super::{Fault, print_frame};

/// Beams as they look at 600 turns a minute, in flash.
static VLP16: [Beam; 16] = velodyne::VLP16.beams_at(600).expect("16 beams");
static VLP32C: [Beam; 32] = velodyne::VLP32C.beams_at(600).expect("32 beams");
static PANDAR40P: [Beam; 40] = hesai::PANDAR40P.beams_at(600).expect("40 beams");

/// A sensor whose packets are understood.
pub struct PacketSensor {
    model: Model,
    grid: SensorGrid<'static>,
}

/// The sensor that a job names in the place of a coder.
pub fn sensor_of(name: CoderName) -> Option<PacketSensor> {
    let (model, grid) = match name {
        CoderName::Vlp16 => (Model::Vlp16, velodyne::VLP16.grid_of(&VLP16)),
        CoderName::Vlp32c => (Model::Vlp32c, velodyne::VLP32C.grid_of(&VLP32C)),
        CoderName::Pandar40p => (Model::Pandar40p, hesai::PANDAR40P.grid_of(&PANDAR40P)),
        _ => return None,
    };
    Some(PacketSensor { model, grid })
}

/// Encodes every turn. A packet that ends a turn is counted as coding: all others only fill the image.
pub fn encode_turns<B: Board>(
    board: &mut B,
    (job, Even { columns, max_range_m }): (&Job<'_>, Even),
    PacketSensor { model, grid }: PacketSensor,
    levels: &mut [u8],
    coder: &mut Rle,
    piece: &mut [u8; PIECE_LEN],
    out: &mut [u8],
) -> Result<(), Fault> {
    let levels = levels.get_mut(..grid.beams.len() * columns).ok_or(Usage::TooManyColumns)?;
    let image = ImageViewMut::new(levels, columns).ok_or(Usage::TooManyColumns)?;
    let scale = Scale::Fixed { max_range_m };
    let config = GridConfig { scale, level_bits: u8::BITS, table: true, ..GridConfig::new(grid, columns as u16) };
    let turns = TurnAssembler::new(Sensor::Spinning(model), ReturnPolicy::Strongest);
    let mut encoder = PacketEncoder::new(&config, turns, [image], coder)?;
    let (mut fill, mut code, mut filled) = (Stage::new(), Stage::new(), Filled::default());
    let (mut packets, mut frames) = (Packets::open(job.scan, piece)?, create_frames(job)?);
    while let Some(packet) = packets.next_packet()? {
        let mut stage = Stage::new();
        let ended = stage.run(board, B::project_pin, || encoder.push(packet, out))?;
        let ends = ended.is_some();
        filled.packets += u32::from(!ends);
        if ends { &mut code } else { &mut fill }.add(&stage);
        if let Some(turn) = ended {
            filled.add(&turn);
            give(job, &turn, out, &mut frames)?;
        }
    }
    if let Some(turn) = code.run(board, B::code_pin, || encoder.finish(out))? {
        filled.add(&turn);
        give(job, &turn, out, &mut frames)?;
    }
    filled.print(job, board, &fill, &code);
    Ok(())
}

fn give(job: &Job<'_>, turn: &EncodedTurn, out: &[u8], file: &mut impl Write) -> Result<(), Fault> {
    let [encoded] = &turn.frames;
    let frame = out.get(..encoded.len).unwrap_or_default();
    file.write_all(frame).map_err(Fault::Host)?;
    print_frame(job, encoded, frame);
    Ok(())
}

/// What all packets held.
#[derive(Default)]
struct Filled {
    /// Packets that ended no turn, and those that did.
    packets: u32,
    turns: u32,
    cells: u32,
    returns: u32,
}

impl Filled {
    fn add(&mut self, turn: &EncodedTurn) {
        let [encoded] = &turn.frames;
        self.turns += 1;
        self.cells += encoded.tally.points;
        self.returns += encoded.tally.returns();
    }

    /// Instructions a cell and a return, in hundredths; those of the packets that ended no turn.
    fn print<B: Board>(&self, job: &Job<'_>, board: &B, fill: &Stage, code: &Stage) {
        let clock = board.clock();
        // The packets that ended a turn, but the stream's end did too, hold as many returns as any other.
        let all = u64::from(self.packets + self.turns.saturating_sub(1)).max(1);
        let hundredths = |of: u32| 100 * fill.cost(clock) * all / (u64::from(of) * u64::from(self.packets)).max(1);
        print_line(format_args!(
            "cost {job} unit={} packets={} cells={} returns={} fill={} hundredths_a_cell={} \
             hundredths_a_return={} code={} stack_bytes={}",
            clock.unit(),
            all,
            self.cells,
            self.returns,
            fill.cost(clock),
            hundredths(self.cells),
            hundredths(self.returns),
            code.cost(clock),
            fill.stack_bytes().max(code.stack_bytes()),
        ));
    }
}

impl From<PushError> for Fault {
    fn from(error: PushError) -> Self {
        match error {
            PushError::Encode(error) => Self::Encode(error),
            PushError::Packet(error) => Self::Refused(error),
            other => unreachable!("{other}"),
        }
    }
}
