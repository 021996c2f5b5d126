// Another dispatch clears the counters of the frame, or a command before it.
fn clear_faults(first: bool) {}
