//! The page in a browser without a window, compared with the CPU backend of this machine.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use gimage_runtime::{Options, Stepper};
use gimage_web::{STEP, scene};

use crate::{Args, Error};

/// Time \[s\] that the page has for all its frames; a software adapter compiles its shaders meanwhile.
const PATIENCE: u64 = 300;
/// Largest distance \[m\] of a particle from where the CPU backend has it.
const LIMIT: f32 = 1e-5;

/// A check under way.
pub struct Check {
    browser: Child,
    _profile: tempfile::TempDir,
    end: Instant,
    expected: Vec<[f32; 4]>,
    picture: Option<PathBuf>,
}

impl Check {
    /// Steps the scene here, and starts the browser.
    pub fn start(args: &Args, frames: u32, url: &str) -> Result<Self, Error> {
        let mut stepper = Stepper::on_cpu(scene(&gimage_bundle::dir::read_dir(&args.bundle)?)?, Options::default())?;
        for _ in 0..frames {
            stepper.advance(STEP)?;
        }
        let expected = stepper.positions(0).unwrap_or_default().to_vec();
        let profile = tempfile::tempdir()?;
        let browser = Command::new(&args.browser)
            .args([
                "--headless",
                "--no-sandbox",
                "--no-first-run",
                "--disable-gpu-sandbox",
                "--disable-quic",
                "--disable-sync",
            ])
            .args(["--disable-background-networking", "--disable-component-update", "--enable-unsafe-webgpu"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(url)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| format!("{}: {e}; name a browser with --browser", args.browser.display()))?;
        let end = Instant::now() + Duration::from_secs(PATIENCE);
        Ok(Check { browser, _profile: profile, end, expected, picture: args.picture.clone() })
    }

    /// Time that is left.
    pub fn left(&self) -> Result<Duration, Error> {
        Ok(self.end.checked_duration_since(Instant::now()).ok_or("the page has not answered in time")?)
    }

    /// Takes in what the page has sent; once the positions are there, whether it has passed.
    pub fn take(&mut self, path: &str, body: &[u8]) -> Result<Option<bool>, Error> {
        match path {
            "about" => eprintln!("{}", String::from_utf8_lossy(body)),
            "picture" => {
                if let Some(path) = &self.picture {
                    let side = (body.len() / 4).isqrt() as u32;
                    image::save_buffer(path, body, side, side, image::ColorType::Rgba8)?;
                }
            }
            "positions" => return Ok(Some(self.compare(body))),
            "error" => return Err(format!("the page: {}", String::from_utf8_lossy(body)).into()),
            _ => {}
        }
        Ok(None)
    }

    fn compare(&self, body: &[u8]) -> bool {
        let numbers: Vec<f32> = body.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        let particles = numbers.as_chunks::<4>().0;
        let apart = |(a, b): (&[f32; 4], &[f32; 4])| {
            let squares: f32 = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
            // NaN is the farthest.
            if squares.is_finite() { squares.sqrt() } else { f32::INFINITY }
        };
        let largest = particles.iter().zip(&self.expected).map(apart).fold(0.0, f32::max);
        let masses = particles.iter().zip(&self.expected).all(|(a, b)| a[3].to_bits() == b[3].to_bits());
        let count = particles.len() == self.expected.len() && !particles.is_empty();
        let passed = count && masses && largest <= LIMIT;
        let verdict = if passed { "as" } else { "NOT as" };
        eprintln!(
            "{} of {} particles, {verdict} on this machine: largest distance {largest:.1e} m (limit {LIMIT:.0e}), inverse masses {}",
            particles.len(),
            self.expected.len(),
            if masses { "equal" } else { "differ" },
        );
        passed
    }
}

impl Drop for Check {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}
