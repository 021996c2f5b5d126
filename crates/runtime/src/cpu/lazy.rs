//! A list that is made when it is first read after a frame.

use std::sync::{Mutex, OnceLock, PoisonError};

/// The list, and the memory of the last one.
pub struct Lazy<A> {
    list: OnceLock<Vec<A>>,
    spare: Mutex<Vec<A>>,
}

impl<A> Lazy<A> {
    /// A list that is there already.
    pub fn new(list: Vec<A>) -> Self {
        Lazy { list: OnceLock::from(list), spare: Mutex::new(Vec::new()) }
    }

    /// The list, empty where it has to be made again.
    pub fn known(&self) -> &[A] {
        self.list.get().map_or(&[], |list| &list[..])
    }

    /// The list has to be made again.
    pub fn forget(&mut self) {
        if let Some(list) = self.list.take() {
            *self.spare.get_mut().unwrap_or_else(PoisonError::into_inner) = list;
        }
    }

    /// The list; `make` fills it where it was forgotten, from whatever is in it.
    pub fn get(&self, make: impl FnOnce(&mut Vec<A>)) -> &[A] {
        self.list.get_or_init(|| {
            let mut list = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
            make(&mut list);
            list
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_made_once_after_it_is_forgotten_and_in_the_same_memory() {
        let mut lazy = Lazy::new(vec![1, 2]);
        assert_eq!(lazy.get(|_| panic!("it is there")), [1, 2]);
        let memory = lazy.get(|_| ()).as_ptr();
        lazy.forget();
        lazy.forget();
        assert_eq!(lazy.get(|list| list[0] = 7), [7, 2]);
        assert_eq!(lazy.get(|_| panic!("it is made")).as_ptr(), memory);
    }
}
