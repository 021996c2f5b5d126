//! Functions that the page calls.

use std::collections::BTreeMap;

use gimage_bundle::Bundle;
use gimage_runtime::{Options, Stepper, device_limits, read_back_async, self_check_async, wgpu};
use js_sys::{Object, Reflect, Uint8Array};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

use crate::scene::{STEP, scene};
use crate::screen::Screen;

/// A garment in motion.
#[wasm_bindgen]
pub struct Garment {
    device: wgpu::Device,
    queue: wgpu::Queue,
    stepper: Stepper,
    screen: Screen,
    adapter: String,
}

fn told(error: impl std::fmt::Display) -> JsError {
    JsError::new(&error.to_string())
}

#[wasm_bindgen]
impl Garment {
    /// Reads the files of a bundle, by name, and gets a device. Without a canvas the pictures lie in a texture ([`Garment::picture`]).
    pub async fn open(files: Object, canvas: Option<HtmlCanvasElement>) -> Result<Garment, JsError> {
        let bundle = Bundle::from_files(&bytes(&files)).map_err(told)?;
        let instance = wgpu::Instance::default();
        let surface =
            canvas.map(|c| instance.create_surface(wgpu::SurfaceTarget::Canvas(c))).transpose().map_err(told)?;
        let wish = wgpu::RequestAdapterOptions { compatible_surface: surface.as_ref(), ..Default::default() };
        let adapter = instance.request_adapter(&wish).await.map_err(told)?;
        let wanted = wgpu::DeviceDescriptor { required_limits: device_limits(&adapter), ..Default::default() };
        let (device, queue) = adapter.request_device(&wanted).await.map_err(told)?;

        // A page cannot wait inside of `Stepper::new`, so the check of the device comes first.
        let check = self_check_async(&device, &queue).await;
        let scene = scene(&bundle).map_err(told)?;
        let (low, high) = scene.cloths[0].bounds().ok_or_else(|| JsError::new("the garment has no particles"))?;
        let stepper = Stepper::new(scene, Options::default(), Some((&device, &queue))).map_err(told)?;
        let screen = Screen::new(&device, &queue, &adapter, surface, (low, high)).map_err(|e| JsError::new(&e))?;
        let found = if check.passed() { "passed its self-check".into() } else { check.found() };
        let adapter = format!("{}, {found}", check.adapter);
        Ok(Garment { device, queue, stepper, screen, adapter })
    }

    /// Steps and draws a frame.
    pub fn frame(&mut self) -> Result<(), JsError> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let progress = self.stepper.record(&mut encoder, STEP).map_err(told)?;
        let frame = self.screen.draw(&mut encoder, &self.stepper, progress.fraction).map_err(told)?;
        self.queue.submit([encoder.finish()]);
        if let Some(frame) = frame {
            self.queue.present(frame);
        }
        self.stepper.settle().map_err(told)
    }

    /// Positions \[m\] of all particles now, four numbers per particle; the fourth is 1/mass.
    pub async fn positions(&self) -> Result<Vec<f32>, JsError> {
        let buffers = self.stepper.buffers(0).ok_or_else(|| JsError::new("the garment has no buffers"))?;
        let positions = read_back_async(&self.device, &self.queue, &buffers.now).await.map_err(told)?;
        Ok(positions.into_flattened())
    }

    /// The last picture, four bytes per pixel, row by row from the top. Only without a canvas.
    pub async fn picture(&self) -> Result<Vec<u8>, JsError> {
        Ok(self.screen.picture(&self.device, &self.queue).await.map_err(told)?.into_flattened())
    }

    /// The adapter, what its self-check found, the backend that runs, and warnings.
    pub fn about(&self) -> String {
        let warnings: Vec<_> = self.stepper.warnings().iter().map(|w| format!("; {w}")).collect();
        format!(
            "{}; {:?} backend, {} substeps{}",
            self.adapter,
            self.stepper.backend(),
            self.stepper.substeps(),
            warnings.concat()
        )
    }
}

/// The files as a bundle is read from them.
fn bytes(files: &Object) -> BTreeMap<String, Vec<u8>> {
    let file = |name: JsValue| {
        let bytes = Reflect::get(files, &name).ok()?;
        Some((name.as_string()?, Uint8Array::new(&bytes).to_vec()))
    };
    Object::keys(files).iter().filter_map(file).collect()
}
