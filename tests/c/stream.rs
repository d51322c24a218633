//! The example client of streams (`examples/c/stream.c`), between a sensor and a receiver on this machine; and a project
//! elsewhere that finds the library by CMake or pkg-config.

use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use flicr::coder::{ContextSettings, SmallModel, Step};
use flicr::geometry::sensors::velodyne;
use flicr::packet::{Model, ReturnPolicy, Sensor, TurnAssembler};
use flicr::stream::{StreamConfig, StreamDecoder, StreamEncoder};
use libtest_mimic::Failed;

use crate::firmware::{root, run, tool};
use crate::writer::Plan;
use crate::{Client, HOST, compile, library, scratch};

/// So many packets fit any socket's buffer.
const BURST: usize = 20;

/// What the sensor sends; one of them is refused.
fn packets() -> Vec<Vec<u8>> {
    let plan = Plan { start_tick: 18_000, ..Plan::new(Model::Vlp16, true) };
    let mut packets = plan.packets(160);
    packets[77][1205] = 0;
    packets
}

/// The example's program, by a name that no other test uses.
fn build(client: Client, name: &str) -> Result<PathBuf, Failed> {
    let program = scratch(&format!("{}-{name}.elf", client.name));
    let flags = [client.flags, &["-std=c99"]].concat();
    run(compile(client.compiler, &flags, "examples/c/stream.c", &program).arg(library(client.target)?))?;
    Ok(program)
}

/// The example, listening to a sensor.
struct Running {
    child: Child,
    printed: BufReader<ChildStdout>,
    sensor: UdpSocket,
    port: u16,
}

impl Running {
    /// It sends to a port of this machine.
    fn start(client: Client, program: PathBuf, to: u16) -> Result<Self, Failed> {
        let mut words: Vec<_> = client.runner.iter().map(std::ffi::OsString::from).collect();
        words.extend([program.into(), "0".into(), "127.0.0.1".into(), to.to_string().into()]);
        let mut child = Command::new(&words[0]).args(&words[1..]).stdout(Stdio::piped()).spawn()?;
        let mut printed = BufReader::new(child.stdout.take().ok_or("no output")?);
        let port = port_after("listening on ", &mut printed)?;
        Ok(Self { child, printed, sensor: UdpSocket::bind("127.0.0.1:0")?, port })
    }

    /// Packets, and the empty one after them; from time to time the program and its receiver get their turn.
    fn send(&self, packets: &[Vec<u8>], mut pause: impl FnMut()) -> Result<(), Failed> {
        for (sent, packet) in packets.iter().map(Vec::as_slice).chain([&[][..]]).enumerate() {
            self.sensor.send_to(packet, ("127.0.0.1", self.port))?;
            if sent % BURST == BURST - 1 {
                pause();
            }
        }
        Ok(())
    }

    /// What it says at its end.
    fn end(mut self) -> Result<String, Failed> {
        let mut said = String::new();
        self.printed.read_to_string(&mut said)?;
        if self.child.wait()?.success() { Ok(said) } else { Err(said.into()) }
    }
}

/// The port at the end of a program's first line, which begins like this.
fn port_after(words: &str, printed: &mut impl BufRead) -> Result<u16, Failed> {
    let mut line = String::new();
    printed.read_line(&mut line)?;
    let port = line.trim().strip_prefix(words).and_then(|address| address.rsplit(':').next());
    Ok(port.ok_or_else(|| format!("{line}: expected {words}"))?.parse()?)
}

/// The sensor's packets go in by UDP, and what comes out by UDP is what Rust makes of them.
pub fn datagrams_are_rusts(client: Client) -> Result<(), Failed> {
    let receiver = UdpSocket::bind("127.0.0.1:0")?;
    let expected = datagrams_of(&packets());
    let running = Running::start(client, build(client, "stream")?, receiver.local_addr()?.port())?;
    let mut received = Vec::new();
    running.send(&packets(), || take(&receiver, &mut received, Duration::from_millis(20)))?;
    while received.len() < expected.len() {
        let before = received.len();
        take(&receiver, &mut received, Duration::from_secs(20));
        if received.len() == before {
            break;
        }
    }
    let said = running.end()?;
    if received != expected {
        return Err(format!("{} datagrams, Rust's {}; {said}", received.len(), expected.len()).into());
    }
    let bytes: usize = expected.iter().map(Vec::len).sum();
    let first = format!("159 packets used, 1 refused; {} returns in", points_in(&received)?.len());
    if said.starts_with(&first) && said.contains(&format!("{} datagrams of {bytes} bytes, 0 not sent", expected.len()))
    {
        Ok(())
    } else {
        Err(format!("{said}: expected {first} ...").into())
    }
}

/// The same into `flicr receive`: its files hold every point, in the order of the datagrams.
pub fn flicr_receives_it(client: Client, flicr: &str) -> Result<(), Failed> {
    // Before the receiver, which would not wait for it.
    let program = build(client, "receive")?;
    let folder = scratch(&format!("{}-turns", client.name));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder)?;
    let mut receive = Command::new(flicr);
    receive.args(["receive", "udp://127.0.0.1:0", "--sensor", "vlp16", "--idle", "3", "--format", "bin", "-o"]);
    let mut receive = receive.arg(&folder).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let mut notes = BufReader::new(receive.stderr.take().ok_or("no stderr")?);
    let running = Running::start(client, program, port_after("note: listening at ", &mut notes)?)?;
    running.send(&packets(), || std::thread::sleep(Duration::from_millis(20)))?;
    let (said, mut summary) = (running.end()?, String::new());
    notes.read_to_string(&mut summary)?;
    if !receive.wait()?.success() {
        return Err(summary.into());
    }
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&folder)?.map(|file| Ok(file?.path())).collect::<Result<_, Failed>>()?;
    files.sort();
    let points = files.iter().flat_map(|file| crate::data::read_points(file));
    let found: Vec<_> = points.map(|[x, y, z, _]| [x, y, z]).collect();
    let expected = points_in(&datagrams_of(&packets()))?;
    if found == expected && files.len() > 1 && summary.contains(" 0 strips missing in 0 turns, 0 datagrams refused") {
        Ok(())
    } else {
        Err(format!("{} points of {} in {} files; {said}; {summary}", found.len(), expected.len(), files.len()).into())
    }
}

/// All that comes until nothing has for this long, in the order in which it was sent.
fn take(receiver: &UdpSocket, received: &mut Vec<Vec<u8>>, patience: Duration) {
    let mut buffer = [0; 2000];
    // A time-out of nothing would be refused.
    let _ = receiver.set_read_timeout(Some(patience));
    while let Ok(len) = receiver.recv(&mut buffer) {
        received.push(buffer[..len].to_vec());
        let _ = receiver.set_read_timeout(Some(Duration::from_millis(20)));
    }
}

/// Rust's own stream of the same packets.
fn datagrams_of(packets: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let beams = velodyne::VLP16.beams_at::<16>(600).expect("16 beams");
    let grid = velodyne::VLP16.grid_of(&beams);
    let settings = ContextSettings::of_levels(grid.range_unit_m).with_step(Step::new(10).expect("not 0"));
    let config = StreamConfig::new(&grid, 1, settings).expect("a valid configuration");
    let mut stream: StreamEncoder<SmallModel, 2> = StreamEncoder::new(config).expect("16 beams fit");
    let mut turns = TurnAssembler::new(Sensor::Spinning(Model::Vlp16), ReturnPolicy::Strongest);
    let mut datagrams = Vec::new();
    let mut send = |datagram: &[u8]| datagrams.push(datagram.to_vec());
    for packet in packets {
        // The one that is refused, the test asks for.
        let _ = turns.push(packet, |event| stream.push(&event, &mut send));
    }
    turns.finish(|event| stream.push(&event, &mut send));
    stream.finish(&mut send);
    datagrams
}

/// Points that Rust's receiver finds.
fn points_in(datagrams: &[Vec<u8>]) -> Result<Vec<[f32; 3]>, Failed> {
    let beams = velodyne::VLP16.beams_at::<16>(600).expect("16 beams");
    let mut decoder = StreamDecoder::default();
    decoder.know(&velodyne::VLP16.grid_of(&beams))?;
    let mut points = Vec::new();
    for datagram in datagrams {
        points.extend(decoder.push(datagram)?.points());
    }
    Ok(points)
}

/// Installs the library, copies a small project to a folder outside the repository, and builds and runs it there.
pub fn is_found(by: &str) -> Result<(), Failed> {
    let folder = std::env::temp_dir().join(format!("flicr-client-{by}-{}", std::process::id()));
    let built = build_elsewhere(by, &folder);
    std::fs::remove_dir_all(&folder)?;
    built
}

fn build_elsewhere(by: &str, folder: &Path) -> Result<(), Failed> {
    let (prefix, project) = (folder.join("a prefix"), folder.join("project"));
    std::fs::create_dir_all(&project)?;
    run(tool("install.sh").arg(&prefix).arg(HOST))?;
    for name in ["CMakeLists.txt", "client.c"] {
        std::fs::copy(root().join("tests/c/package").join(name), project.join(name))?;
    }
    let client = if by == "cmake" { by_cmake(&prefix, &project)? } else { by_pkg_config(&prefix, &project)? };
    let printed = run(&mut Command::new(client))?;
    let expected = format!("flicr {}: ", flicr::capi::flicr_version());
    if printed.starts_with(&expected) { Ok(()) } else { Err(printed.into()) }
}

fn by_cmake(prefix: &Path, project: &Path) -> Result<PathBuf, String> {
    let build = project.join("build");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(project).arg("-B").arg(&build).arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    run(&mut configure)?;
    run(Command::new("cmake").arg("--build").arg(&build))?;
    Ok(build.join("client"))
}

fn by_pkg_config(prefix: &Path, project: &Path) -> Result<PathBuf, String> {
    let client = project.join("client");
    let mut shell = Command::new("sh");
    // As a user's build does it: what pkg-config says is words for a shell.
    shell.args(["-c", "eval cc -std=c99 client.c -o client $(pkg-config --cflags --libs flicr)"]);
    shell.current_dir(project).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    run(&mut shell)?;
    Ok(client)
}
