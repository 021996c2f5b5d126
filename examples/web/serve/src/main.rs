//! Serves the page of `gimage-web` with a bundle; with `--check`, runs it in a browser without a window and compares it with the CPU
//! backend of this machine.

mod check;
mod files;

use std::path::PathBuf;
use std::process::ExitCode;

use check::Check;
use clap::Parser;
use files::Files;
use tiny_http::{Method, Response, Server};

/// Serves a page that steps a garment in a browser.
#[derive(Parser)]
#[command(
    after_help = "Examples:\n  gimage-web-serve shirt.gim\n  gimage-web-serve shirt.gim --check 30 --picture shirt.png"
)]
struct Args {
    /// A bundle.
    bundle: PathBuf,
    /// Module built by `cargo build -p gimage-web --release --target wasm32-unknown-unknown`.
    #[arg(long, default_value = "target/wasm32-unknown-unknown/release/gimage_web.wasm")]
    wasm: PathBuf,
    /// Port on this machine; 0 for any that is free.
    #[arg(long, default_value_t = 8000)]
    port: u16,
    /// Steps this many frames in a browser without a window and compares the positions with those of this machine's CPU. Exit status 1 if
    /// they differ by more than 1e-5 m.
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(1..))]
    check: Option<u32>,
    /// The browser of the check, Chromium or one with its flags.
    #[arg(long, default_value = "chromium", requires = "check")]
    browser: PathBuf,
    /// Writes the last picture of the check to this PNG.
    #[arg(long, requires = "check")]
    picture: Option<PathBuf>,
}

type Error = Box<dyn std::error::Error + Send + Sync>;

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("gimage-web-serve: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<bool, Error> {
    let files = Files::new(&args.wasm, &args.bundle)?;
    let server = Server::http(("127.0.0.1", args.port))?;
    let address = server.server_addr();
    let mut check = match args.check {
        Some(frames) => Some(Check::start(args, frames, &format!("http://{address}/?check={frames}"))?),
        None => {
            eprintln!("http://{address}/");
            None
        }
    };
    loop {
        let mut request = match &check {
            Some(check) => server.recv_timeout(check.left()?)?.ok_or("the page has not answered in time")?,
            None => server.recv()?,
        };
        if *request.method() != Method::Post {
            files.answer(request)?;
            continue;
        }
        let mut body = Vec::new();
        request.as_reader().read_to_end(&mut body)?;
        let path = request.url().trim_start_matches('/').to_string();
        request.respond(Response::empty(200))?;
        if let Some(passed) = check.as_mut().map(|c| c.take(&path, &body)).transpose()?.flatten() {
            return Ok(passed);
        }
    }
}
