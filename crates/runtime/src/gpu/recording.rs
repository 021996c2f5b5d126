//! The compute passes of a frame: one, or one per run of dispatches of a shader where each is timed.

/// The compute passes of a frame in the host's encoder.
pub(super) struct Recording<'a> {
    encoder: &'a mut wgpu::CommandEncoder,
    pass: Option<wgpu::ComputePass<'static>>,
    /// Queries that are left, and the number of compute passes that all of them are enough for.
    queries: Option<(&'a wgpu::QuerySet, u32)>,
    /// Whether each shader has a compute pass of its own.
    pub each: bool,
    /// The shader and the dispatches of each compute pass that is timed.
    spans: Vec<(&'static str, u32)>,
}

impl<'a> Recording<'a> {
    pub fn new(
        encoder: &'a mut wgpu::CommandEncoder,
        queries: Option<(&'a wgpu::QuerySet, u32)>,
        each: bool,
    ) -> Recording<'a> {
        Recording { encoder, pass: None, queries, each, spans: Vec::new() }
    }

    /// The compute pass for a dispatch of a shader. Its name counts only where each is timed.
    pub fn pass(&mut self, shader: &'static str) -> &mut wgpu::ComputePass<'static> {
        if self.each && self.spans.last().is_some_and(|last| last.0 != shader) {
            self.pass = None;
        }
        let pass = match self.pass.take() {
            Some(pass) => pass,
            None => self.open(shader),
        };
        if let (Some(_), Some(last)) = (self.queries, self.spans.last_mut()) {
            last.1 += 1;
        }
        self.pass.insert(pass)
    }

    fn open(&mut self, shader: &'static str) -> wgpu::ComputePass<'static> {
        let place = self.spans.len() as u32;
        // Passes behind the last query are not timed, and need not be apart.
        self.queries = self.queries.filter(|(_, most)| place < *most);
        self.each &= self.queries.is_some();
        let writes = |(query_set, _)| wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(2 * place),
            end_of_pass_write_index: Some(2 * place + 1),
        };
        self.spans.extend(self.queries.map(|_| (shader, 0)));
        let (label, timestamp_writes) = (Some(if self.each { shader } else { "cloth" }), self.queries.map(writes));
        self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes }).forget_lifetime()
    }

    /// The encoder between two compute passes.
    pub fn between(&mut self) -> &mut wgpu::CommandEncoder {
        self.pass = None;
        self.encoder
    }

    /// The shader and the dispatches of each compute pass that is timed.
    pub fn end(self) -> Vec<(&'static str, u32)> {
        self.spans
    }
}
