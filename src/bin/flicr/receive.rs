//! `flicr receive`: a stream of datagrams to turns, as the sensor turns.

mod screen;
mod source;
mod tally;

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use flicr::files::PointCloud;
use flicr::stream::{Deframer, ReceivedTurn, StreamDecoder, StreamLosses};

use crate::args::word;
use crate::failure::Failure;
use crate::output::Outputs;
use crate::sensors::{self, Asked};
use crate::table::grouped;
use screen::Screen;
use source::{Message, Source};
use tally::Tally;

/// Receive a stream of datagrams, show it, and write its turns
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Receive {
    /// Where they come from: udp://ADDRESS:PORT (this machine's), tcp:HOST:PORT or unix:PATH (the sender's), a serial
    /// device, a file, or - for stdin
    #[arg(value_name = "SOURCE")]
    source: Source,
    /// Whose datagrams: auto (all built-in sensors), a built-in one's name, a file of `flicr calibrate` (.toml) or an
    /// Ouster's metadata (.json)
    #[arg(long, value_name = "SENSOR", default_value = "auto")]
    sensor: String,
    /// A folder that is there, for a file each turn
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// What kind of files
    #[arg(long, value_enum, default_value_t)]
    format: FormatName,
    /// Ends when nothing has come for so long; 0: never
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds)]
    idle: f32,
    /// Ends after so many turns
    #[arg(long, value_name = "N")]
    turns: Option<u64>,
}

const EXAMPLES: &str = "\
Over UDP each datagram is one of the stream's; everything else is a stream of bytes, framed by COBS (flicr::stream::write_framed).
A serial line's speed is set beforehand: stty -F /dev/ttyUSB0 raw 3000000.
On a terminal the newest columns are drawn all around, red near and blue far; else each turn is a line.
Latency is how many columns a strip's oldest return has waited for it to be full.
Ctrl-C, the source's end, --idle and --turns end it; then stderr has a summary.

Examples:
  flicr receive udp://0.0.0.0:2400
  flicr receive /dev/ttyUSB0 --sensor vlp16 -o turns/
  flicr receive tcp:localhost:2400 -o turns/ --format bin --turns 100";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum FormatName {
    #[default]
    Pcd,
    Bin,
}

fn seconds(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected a number of seconds".to_owned()),
    }
}

/// Ctrl-C was pressed.
static IS_ENDED: AtomicBool = AtomicBool::new(false);
/// How often it is looked whether it was.
const BEAT: Duration = Duration::from_millis(100);
/// The longest datagram of a byte stream.
const DATAGRAM_LEN_MAX: usize = 1 << 16;

impl Receive {
    pub fn run(self) -> Result<(), Failure> {
        let mut session = Session::new(self)?;
        let messages = session.receive.source.open()?;
        ctrlc::set_handler(|| IS_ENDED.store(true, Ordering::Relaxed))
            .map_err(|error| Failure::Usage(format!("Ctrl-C: {error}")))?;
        let mut heard = Instant::now();
        let failure = loop {
            match messages.recv_timeout(BEAT) {
                Ok(Message::End(error)) => break error,
                Ok(message) => {
                    heard = Instant::now();
                    session.take(&message, heard)?;
                }
                Err(RecvTimeoutError::Timeout) if !session.is_idle(heard) => {}
                Err(_) => break None,
            }
            if IS_ENDED.load(Ordering::Relaxed) || session.has_all_turns() {
                break None;
            }
        };
        session.finish()?;
        failure.map_or(Ok(()), |error| Err(Failure::Data(error.to_string())))
    }
}

/// All that is known of what came.
struct Session {
    receive: Receive,
    deframer: Box<Deframer<DATAGRAM_LEN_MAX>>,
    decoder: StreamDecoder,
    tally: Tally,
    screen: Option<Screen>,
    /// What was last said of a turn.
    line: String,
}

impl Session {
    fn new(receive: Receive) -> Result<Self, Failure> {
        if let Some(folder) = receive.output.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(Failure::usage(folder, "expected a folder that is there"));
        }
        let mut decoder = StreamDecoder::default();
        let known =
            if receive.sensor == "auto" { sensors::built_in() } else { vec![Asked::named(&receive.sensor)?.grid()] };
        for grid in known {
            decoder.know(&grid.grid()).map_err(|error| Failure::Usage(format!("{}: {error}", receive.sensor)))?;
        }
        let (deframer, screen) = (Box::new(Deframer::new()), Screen::on_terminal());
        Ok(Self { receive, deframer, decoder, tally: Tally::new(), screen, line: String::new() })
    }

    fn is_idle(&self, heard: Instant) -> bool {
        self.receive.idle > 0.0 && heard.elapsed().as_secs_f32() > self.receive.idle
    }

    fn has_all_turns(&self) -> bool {
        self.receive.turns.is_some_and(|turns| self.tally.total.turns >= turns)
    }

    fn take(&mut self, message: &Message, now: Instant) -> Result<(), Failure> {
        match message {
            Message::Datagram(datagram) => self.take_datagram(datagram, now)?,
            Message::Bytes(bytes) => {
                let mut datagrams = Vec::new();
                self.deframer.push(bytes, |datagram| datagrams.push(datagram.to_vec()));
                datagrams.iter().try_for_each(|datagram| self.take_datagram(datagram, now))?;
            }
            Message::End(_) => {}
        }
        self.draw(now)
    }

    fn take_datagram(&mut self, datagram: &[u8], now: Instant) -> Result<(), Failure> {
        if self.has_all_turns() {
            return Ok(());
        }
        self.tally.take_datagram(datagram.len(), now);
        // What is refused is counted.
        if let Ok(strip) = self.decoder.push(datagram) {
            self.tally.take_strip(strip);
            if let Some(screen) = &mut self.screen {
                screen.take(strip);
            }
        }
        self.take_turns(now)
    }

    fn take_turns(&mut self, now: Instant) -> Result<(), Failure> {
        while !self.has_all_turns() {
            let Some(turn) = self.decoder.next_turn() else { break };
            self.take_turn(&turn, now)?;
        }
        Ok(())
    }

    fn take_turn(&mut self, turn: &ReceivedTurn, now: Instant) -> Result<(), Failure> {
        let points = turn.points();
        self.line = self.tally.take_turn(turn, points.len(), now);
        if self.screen.is_none() {
            writeln!(io::stdout(), "{}", self.line)?;
        }
        let Some(folder) = &self.receive.output else { return Ok(()) };
        // Turns' numbers come round after 65,536, and a sender may begin anew: these do not.
        let name = format!("{:06}.{}", self.tally.total.turns - 1, word(&self.receive.format));
        let mut outputs = Outputs::default();
        outputs.stage_cloud(&folder.join(name), &PointCloud { points, ..PointCloud::default() })?;
        outputs.commit()
    }

    fn draw(&mut self, now: Instant) -> Result<(), Failure> {
        let Some(screen) = &mut self.screen else { return Ok(()) };
        let told = format!("{}; {}", self.tally.rates(now), losses(self.decoder.losses()));
        screen.draw(now, [&self.line, &told])
    }

    /// What is open counts as over.
    fn finish(mut self) -> Result<(), Failure> {
        self.decoder.flush();
        self.take_turns(Instant::now())?;
        if let Some(screen) = &self.screen {
            screen.end()?;
        }
        let noise = match self.deframer.refused() {
            0 => String::new(),
            frames => format!(", {} frames torn", grouped(frames.into())),
        };
        let summary = format!("{}; {}{noise}", self.tally.summary(), losses(self.decoder.losses()));
        // Where stderr is closed, nobody wants to know.
        let _ = writeln!(io::stderr(), "note: {summary}");
        Ok(())
    }
}

fn losses(losses: StreamLosses) -> String {
    format!(
        "{} strips missing in {} turns, {} datagrams refused",
        grouped(losses.missing_strips),
        grouped(losses.incomplete_turns),
        grouped(losses.refused),
    )
}
