//! Emulated boards that stream.

use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::thread;

use libtest_mimic::Failed;

pub use crate::boards::Board;
use crate::boards::boards;
use crate::firmware::{run, tool};

pub static BOARDS: [Board; 4] = boards("live_cortex_m", "live_aarch64");

impl Board {
    /// Streams from file to file, without interrupts; gives what was printed.
    pub fn stream_files(&'static self, job: &str, packets: &Path, datagrams: &Path) -> Result<String, Failed> {
        let firmware = self.built()?;
        Ok(run(tool("emulate.sh").arg(self.name).arg(firmware).arg(job).arg(packets).arg(datagrams))?)
    }

    /// Streams from UART to UART, or both ways over the only one; gives what was printed. The emulator takes a byte only
    /// when the firmware has read the one before, so that nothing is ever lost.
    pub fn stream_uarts(&'static self, job: &str, packets: Vec<u8>, datagrams: &Path) -> Result<String, Failed> {
        let firmware = self.built()?;
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let address = listener.local_addr()?;
        let serial = if self.is_thumb() {
            format!("file:{} tcp:{address}", datagrams.display())
        } else {
            format!("tcp:{address}")
        };
        let line = thread::spawn(move || talk(&listener, &packets));
        let mut emulator = tool("emulate.sh");
        let printed = run(emulator.env("FLICR_SERIAL", serial).arg(self.name).arg(firmware).args([job, "uart"]))?;
        let came = line.join().map_err(|_| "the line's other end panicked")??;
        if !self.is_thumb() {
            std::fs::write(datagrams, came)?;
        }
        Ok(printed)
    }
}

/// Sends bytes and gives those that come back.
fn talk(listener: &TcpListener, bytes: &[u8]) -> io::Result<Vec<u8>> {
    let (mut stream, _) = listener.accept()?;
    let mut back = stream.try_clone()?;
    let reader = thread::spawn(move || {
        let mut came = Vec::new();
        // The emulator's end is the stream's; whatever way it ends, what came is looked at.
        let _ = back.read_to_end(&mut came);
        came
    });
    stream.write_all(bytes)?;
    reader.join().map_err(|_| io::ErrorKind::Other.into())
}
