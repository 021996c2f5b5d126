/// What is wrong with a bundle.
#[derive(Debug, thiserror::Error)]
pub enum Error {}
