//! Just enough of a GLB reader to look at the files from outside.

use serde_json::Value;

pub struct Glb {
    pub doc: Value,
    data: Vec<u8>,
}

impl Glb {
    pub fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let end = 20 + word(12);
        let doc = serde_json::from_slice(&bytes[20..end]).expect("JSON");
        Self { doc, data: bytes[end + 8..end + 8 + word(end)].to_vec() }
    }

    fn raw(&self, accessor: usize) -> &[u8] {
        let a = &self.doc["accessors"][accessor];
        let view = &self.doc["bufferViews"][a["bufferView"].as_u64().expect("view") as usize];
        let number = |key: &str| view[key].as_u64().expect("number") as usize;
        &self.data[number("byteOffset")..number("byteOffset") + number("byteLength")]
    }

    pub fn accessor<const N: usize>(&self, index: usize) -> Vec<[f32; N]> {
        assert_eq!(self.doc["accessors"][index]["componentType"], 5126);
        let floats: Vec<f32> = self.raw(index).as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        floats.as_chunks::<N>().0.to_vec()
    }

    fn primitive(&self, mesh: usize) -> &Value {
        &self.doc["meshes"][mesh]["primitives"][0]
    }

    fn attribute(&self, mesh: usize, name: &str) -> usize {
        self.primitive(mesh)["attributes"][name].as_u64().expect(name) as usize
    }

    pub fn floats_of<const N: usize>(&self, mesh: usize, name: &str) -> Vec<[f32; N]> {
        self.accessor(self.attribute(mesh, name))
    }

    pub fn bytes_of(&self, mesh: usize, name: &str) -> &[u8] {
        self.raw(self.attribute(mesh, name))
    }

    pub fn triangles_of(&self, mesh: usize) -> Vec<[usize; 3]> {
        let index = self.primitive(mesh)["indices"].as_u64().expect("indices") as usize;
        let raw = self.raw(index);
        let all: Vec<usize> = match self.doc["accessors"][index]["componentType"].as_u64() {
            Some(5123) => raw.as_chunks::<2>().0.iter().map(|b| usize::from(u16::from_le_bytes(*b))).collect(),
            Some(5125) => raw.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b) as usize).collect(),
            other => panic!("index type {other:?}"),
        };
        all.as_chunks::<3>().0.to_vec()
    }
}
