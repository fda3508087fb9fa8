//! Where a recording goes: a file, a viewer, or every client.

use std::fs;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use ::rerun::external::re_uri::RedapUri;
use ::rerun::log::ChunkBatcherConfig;
use ::rerun::{RecordingStream, RecordingStreamBuilder, SpawnError};

use super::{RerunError, refused, unwritable};

/// Where a viewer listens, and where [`Sink::Serve`] does, if nothing else is said.
pub const DEFAULT_PORT: u16 = 9876;

/// How long a viewer may take to open its port.
const START_PATIENCE: Duration = Duration::from_secs(20);

/// Where a recording goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Sink {
    /// Into a file whose name ends in `.rrd`; while the run lasts, in `.partial.rrd`.
    Save(PathBuf),
    /// To a viewer on this machine; starts one unless one listens already.
    Spawn,
    /// To a viewer that runs elsewhere: its address, or the usual one on this machine.
    Connect(Option<String>),
    /// To every client. Late viewers get all from the start, until the stream is dropped.
    Serve {
        /// Address to listen on.
        bind: IpAddr,
        /// Port to listen on, 0 for a free one; with the feature `rerun-web`, the page is one above.
        port: u16,
    },
}

impl Sink {
    /// Serves viewers on this machine.
    pub fn serve_here() -> Self {
        Self::Serve { bind: Ipv4Addr::LOCALHOST.into(), port: DEFAULT_PORT }
    }

    /// Opens it.
    pub(super) fn open(
        &self,
        builder: RecordingStreamBuilder,
    ) -> Result<(RecordingStream, Destination), RerunError> {
        match self {
            Self::Save(path) => save(builder, path),
            Self::Spawn => spawn(builder),
            Self::Connect(url) => connect(builder, url.as_deref()),
            Self::Serve { bind, port } => serve(builder, *bind, *port),
        }
    }
}

/// What a [`Sink`] has become.
pub(super) enum Destination {
    File {
        partial: PathBuf,
        path: PathBuf,
    },
    Viewer {
        url: String,
    },
    Server {
        url: String,
        #[cfg(feature = "rerun-web")]
        page: Page,
    },
}

fn save(builder: RecordingStreamBuilder, path: &Path) -> Result<(RecordingStream, Destination), RerunError> {
    if path.extension().is_none_or(|extension| extension != "rrd") {
        return Err(RerunError::NotRrd { path: path.into() });
    }
    if path.is_dir() {
        return Err(unwritable(path, "it is a folder"));
    }
    let partial = path.with_extension("partial.rrd");
    // Tried first because the package would wrap the system's words.
    fs::File::create(&partial).map_err(|error| unwritable(path, error))?;
    let recording =
        builder.batcher_config(file_batches()).save(&partial).map_err(|error| unwritable(path, error))?;
    let path = path.into();
    Ok((recording, Destination::File { partial, path }))
}

fn spawn(builder: RecordingStreamBuilder) -> Result<(RecordingStream, Destination), RerunError> {
    let options =
        ::rerun::SpawnOptions { port: DEFAULT_PORT, hide_welcome_screen: true, ..Default::default() };
    ::rerun::spawn(&options).map_err(|error| match error {
        SpawnError::Io(error) => RerunError::ViewerBroken(error),
        SpawnError::ExecutableNotFoundInPath { .. } | SpawnError::ExecutableNotFound { .. } => {
            RerunError::ViewerMissing
        }
    })?;
    // The package's own wait asserts, and would end a debug build.
    let started = Instant::now();
    while try_port(&options.connect_addr().to_string()).is_err() {
        if started.elapsed() > START_PATIENCE {
            return Err(RerunError::ViewerSilent { port: options.port, seconds: START_PATIENCE.as_secs() });
        }
        thread::sleep(Duration::from_millis(100));
    }
    connect(builder, None)
}

fn connect(
    builder: RecordingStreamBuilder,
    url: Option<&str>,
) -> Result<(RecordingStream, Destination), RerunError> {
    let url = match url {
        Some(url) if url.contains("://") => url.to_owned(),
        Some(host) if host.contains(':') => format!("rerun+http://{host}/proxy"),
        Some(host) => format!("rerun+http://{host}:{DEFAULT_PORT}/proxy"),
        None => format!("rerun+http://127.0.0.1:{DEFAULT_PORT}/proxy"),
    };
    let Ok(RedapUri::Proxy(proxy)) = url.parse() else {
        return Err(RerunError::BadAddress { url });
    };
    // The package would try for ever, in silence.
    let address = format!("{}:{}", proxy.origin.host, proxy.origin.port);
    if let Err(source) = try_port(&address) {
        return Err(RerunError::NoAnswer { url, source });
    }
    let recording = builder
        .batcher_config(live_batches())
        .connect_grpc_opts(&url)
        .map_err(refused("the viewer's address"))?;
    Ok((recording, Destination::Viewer { url }))
}

fn try_port(address: &str) -> io::Result<()> {
    let mut outcome = Err(io::ErrorKind::AddrNotAvailable.into());
    for address in address.to_socket_addrs()? {
        outcome = TcpStream::connect_timeout(&address, Duration::from_secs(2)).map(drop);
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}

fn serve(
    builder: RecordingStreamBuilder,
    bind: IpAddr,
    port: u16,
) -> Result<(RecordingStream, Destination), RerunError> {
    let port = free_port(SocketAddr::new(bind, port))?;
    let seen_from_here = match bind {
        IpAddr::V4(ip) if ip.is_unspecified() => "127.0.0.1".to_owned(),
        IpAddr::V6(ip) if ip.is_unspecified() => "[::1]".to_owned(),
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    let listen_on = match bind {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    let url = format!("rerun+http://{seen_from_here}:{port}/proxy");
    #[cfg(feature = "rerun-web")]
    let page = Page::serve(SocketAddr::new(bind, port.wrapping_add(1)), &seen_from_here, &url)?;
    let recording = builder
        .batcher_config(live_batches())
        .serve_grpc_opts(listen_on, port, Default::default())
        .map_err(refused("the address to serve on"))?;
    Ok((
        recording,
        Destination::Server {
            url,
            #[cfg(feature = "rerun-web")]
            page,
        },
    ))
}

/// The port, or a free one for 0. The package would fail on a thread of its own, in silence.
fn free_port(address: SocketAddr) -> Result<u16, RerunError> {
    TcpListener::bind(address)
        .and_then(|listener| listener.local_addr())
        .map(|bound| bound.port())
        .map_err(|source| RerunError::CannotListen { address, source })
}

/// Cut by number of samples alone, never by wall time or memory, so that equal runs give equal files.
fn file_batches() -> ChunkBatcherConfig {
    ChunkBatcherConfig {
        flush_tick: Duration::MAX,
        flush_num_bytes: u64::MAX,
        flush_num_rows: 256,
        ..ChunkBatcherConfig::DEFAULT
    }
}

/// Sends soon, and waits for no viewer before 1 GiB lies there.
fn live_batches() -> ChunkBatcherConfig {
    ChunkBatcherConfig { max_bytes_in_flight: 1 << 30, ..ChunkBatcherConfig::LOW_LATENCY }
}

/// The viewer as a web page.
#[cfg(feature = "rerun-web")]
pub(super) struct Page {
    pub url: String,
    /// Serves until dropped; its type cannot be named from here.
    _server: Box<dyn std::any::Any + Send>,
}

#[cfg(feature = "rerun-web")]
impl Page {
    fn serve(address: SocketAddr, host: &str, data: &str) -> Result<Self, RerunError> {
        let port = free_port(address)?;
        let cannot_listen =
            |error: String| RerunError::CannotListen { address, source: io::Error::other(error) };
        let server = ::rerun::web_viewer::WebViewerConfig {
            bind_ip: address.ip().to_string(),
            web_port: (port.to_string().parse()).map_err(&cannot_listen)?,
            open_browser: false,
            ..Default::default()
        };
        let server = server.host_web_viewer().map_err(|error| cannot_listen(error.to_string()))?;
        Ok(Self {
            url: format!("http://{host}:{port}/?url={}", data.replace('+', "%2B")),
            _server: Box::new(server),
        })
    }
}
