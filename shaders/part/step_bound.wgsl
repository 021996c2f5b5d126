// One step a dispatch.
@group(0) @binding(0) var<uniform> step: Step;
