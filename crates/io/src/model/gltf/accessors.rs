//! Reads the numbers of accessors, after a check of their ranges.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

use ::gltf::accessor::{DataType, Dimensions, Item, Iter};
use ::gltf::{Accessor, Buffer};

use super::super::error::Fault;
use super::buffers::Buffers;

/// Elements of an accessor.
pub(super) type Read<T> = Rc<[T]>;

/// Reads accessors. Those of the attributes of vertices are read once, because meshes may share them.
pub(super) struct Accessors<'b> {
    buffers: &'b Buffers,
    positions: Cache<[f32; 3]>,
    coordinates: Cache<[f32; 2]>,
    joints: Cache<[u16; 4]>,
    weights: Cache<[f32; 4]>,
    colors: Cache<[f32; 4]>,
    numbers: Cache<f32>,
    /// Number of elements that may still be read.
    budget: Cell<usize>,
}

/// Accessors that were read, by their indices.
struct Cache<T>(RefCell<HashMap<usize, Read<T>>>);

/// Number of elements that meshes in several places and primitives with shared data may have, besides as many elements as
/// the file has bytes.
const REPEATED: usize = 1 << 22;

impl<T> Cache<T> {
    fn new() -> Self {
        Self(RefCell::default())
    }

    fn get(
        &self,
        accessor: &Accessor<'_>,
        read: impl FnOnce() -> Result<Read<T>, Fault>,
    ) -> Result<Read<T>, Fault> {
        if let Some(found) = self.0.borrow().get(&accessor.index()) {
            return Ok(found.clone());
        }
        let found = read()?;
        self.0.borrow_mut().insert(accessor.index(), found.clone());
        Ok(found)
    }
}

impl<'b> Accessors<'b> {
    /// `size` is the size of the file without buffers, in bytes.
    pub(super) fn new(buffers: &'b Buffers, size: usize) -> Self {
        let budget = Cell::new(size.saturating_add(buffers.size()).saturating_add(REPEATED));
        let (positions, coordinates) = (Cache::new(), Cache::new());
        let (joints, weights) = (Cache::new(), Cache::new());
        let (colors, numbers) = (Cache::new(), Cache::new());
        Self { buffers, positions, coordinates, joints, weights, colors, numbers, budget }
    }

    /// Returns the number of elements that may still be read.
    pub(super) fn left(&self) -> usize {
        self.budget.get()
    }

    /// Counts elements that are read or made.
    pub(super) fn spend(&self, count: usize) -> Result<(), Fault> {
        match self.budget.get().checked_sub(count) {
            Some(left) => {
                self.budget.set(left);
                Ok(())
            }
            None => Err(Fault(format!(
                "its meshes together, each as often as nodes show it, have {REPEATED} elements more than the file has bytes; \
                 export it without repeated meshes"
            ))),
        }
    }

    /// Reads positions or displacements. `element` describes them in messages.
    pub(super) fn positions(&self, accessor: &Accessor<'_>, element: &str) -> Result<Read<[f32; 3]>, Fault> {
        self.positions.get(accessor, || match (accessor.data_type(), accessor.dimensions()) {
            (DataType::F32, Dimensions::Vec3) => self.read(accessor, element),
            (DataType::F32, _) => Err(self.mismatch(accessor, element, "VEC3")),
            (found, _) => Err(Fault(format!(
                "{element} is quantized: its numbers have the type {found:?}, not F32; run: gltf-transform dequantize IN OUT"
            ))),
        })
    }

    /// Reads texture coordinates, with the origin at the upper left of the image.
    pub(super) fn coordinates(
        &self,
        accessor: &Accessor<'_>,
        element: &str,
    ) -> Result<Read<[f32; 2]>, Fault> {
        let is_pair = accessor.dimensions() == Dimensions::Vec2;
        self.coordinates.get(accessor, || self.read_fractions(accessor, element, (is_pair, "VEC2")))
    }

    /// Reads the joints of vertices.
    pub(super) fn joints(&self, accessor: &Accessor<'_>, element: &str) -> Result<Read<[u16; 4]>, Fault> {
        self.joints.get(accessor, || match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Vec4) => Ok(self
                .read::<[u8; 4]>(accessor, element)?
                .iter()
                .map(|joints| joints.map(u16::from))
                .collect()),
            (DataType::U16, Dimensions::Vec4) => self.read(accessor, element),
            _ => Err(self.mismatch(accessor, element, "VEC4 of whole numbers")),
        })
    }

    /// Reads the weights of joints.
    pub(super) fn weights(&self, accessor: &Accessor<'_>, element: &str) -> Result<Read<[f32; 4]>, Fault> {
        let is_four = accessor.dimensions() == Dimensions::Vec4;
        self.weights.get(accessor, || self.read_fractions(accessor, element, (is_four, "VEC4")))
    }

    /// Reads colors. Colors of three numbers are opaque.
    pub(super) fn colors(&self, accessor: &Accessor<'_>, element: &str) -> Result<Read<[f32; 4]>, Fault> {
        let size = (accessor.dimensions() == Dimensions::Vec4, "VEC3 or VEC4");
        self.colors.get(accessor, || match accessor.dimensions() {
            Dimensions::Vec3 => {
                let read = self.read_fractions(accessor, element, (true, "VEC3 or VEC4"))?;
                Ok(read.iter().map(|&[red, green, blue]| [red, green, blue, 1.0]).collect())
            }
            _ => self.read_fractions(accessor, element, size),
        })
    }

    /// Reads numbers of an application, as they are or, if they are normalized, as fractions of their greatest value.
    /// `None` for vectors and matrices, and for whole numbers with signs or of 32 bits.
    pub(super) fn numbers(&self, accessor: &Accessor<'_>, element: &str) -> Result<Option<Read<f32>>, Fault> {
        let greatest = |greatest: f32| if accessor.normalized() { greatest } else { 1.0 };
        let kind = accessor.data_type();
        let is_read = matches!(kind, DataType::F32 | DataType::U8 | DataType::U16);
        if !is_read || accessor.dimensions() != Dimensions::Scalar {
            return Ok(None);
        }
        let numbers = self.numbers.get(accessor, || match kind {
            DataType::U8 => {
                let read = self.read::<u8>(accessor, element)?;
                Ok(read.iter().map(|&x| f32::from(x) / greatest(255.0)).collect())
            }
            DataType::U16 => {
                let read = self.read::<u16>(accessor, element)?;
                Ok(read.iter().map(|&x| f32::from(x) / greatest(65535.0)).collect())
            }
            _ => self.read(accessor, element),
        });
        numbers.map(Some)
    }

    /// Reads the indices of a primitive.
    pub(super) fn indices(&self, accessor: &Accessor<'_>, element: &str) -> Result<Vec<u32>, Fault> {
        match (accessor.data_type(), accessor.dimensions()) {
            (DataType::U8, Dimensions::Scalar) => {
                Ok(self.read::<u8>(accessor, element)?.iter().map(|&index| index.into()).collect())
            }
            (DataType::U16, Dimensions::Scalar) => {
                Ok(self.read::<u16>(accessor, element)?.iter().map(|&index| index.into()).collect())
            }
            (DataType::U32, Dimensions::Scalar) => Ok(self.read::<u32>(accessor, element)?.to_vec()),
            _ => Err(self.mismatch(accessor, element, "SCALAR of whole numbers")),
        }
    }

    /// Reads matrices, by columns.
    pub(super) fn matrices(
        &self,
        accessor: &Accessor<'_>,
        element: &str,
    ) -> Result<Read<[[f32; 4]; 4]>, Fault> {
        match (accessor.data_type(), accessor.dimensions()) {
            (DataType::F32, Dimensions::Mat4) => self.read(accessor, element),
            _ => Err(self.mismatch(accessor, element, "MAT4")),
        }
    }

    /// Reads vectors of numbers, of which whole ones are fractions of their greatest value. `has_size`: whether the accessor has
    /// vectors of `N` numbers, which messages call `expected`.
    fn read_fractions<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        element: &str,
        (has_size, expected): (bool, &str),
    ) -> Result<Read<[f32; N]>, Fault>
    where
        [f32; N]: Item,
        [u8; N]: Item,
        [u16; N]: Item,
    {
        match accessor.data_type() {
            DataType::F32 if has_size => self.read(accessor, element),
            DataType::U8 if has_size => {
                let read = self.read::<[u8; N]>(accessor, element)?;
                Ok(read.iter().map(|x| x.map(|x| f32::from(x) / 255.0)).collect())
            }
            DataType::U16 if has_size => {
                let read = self.read::<[u16; N]>(accessor, element)?;
                Ok(read.iter().map(|x| x.map(|x| f32::from(x) / 65535.0)).collect())
            }
            _ => Err(self.mismatch(accessor, element, expected)),
        }
    }

    fn mismatch(&self, accessor: &Accessor<'_>, element: &str, expected: &str) -> Fault {
        let (found, dimensions) = (accessor.data_type(), accessor.dimensions());
        Fault(format!(
            "{element} is {dimensions:?} of {found:?} in place of {expected}; export the file again"
        ))
    }

    /// Reads elements of `T`, the type of the accessor.
    fn read<T: Item>(&self, accessor: &Accessor<'_>, element: &str) -> Result<Read<T>, Fault> {
        let (count, size) = (accessor.count(), size_of::<T>());
        self.spend(count)?;
        if count == 0 {
            return Ok(Vec::new().into());
        }
        if let Some(view) = accessor.view() {
            self.buffers.check(&view, (accessor.offset(), count, size), element)?;
        }
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let (sparse_count, index_size) = (sparse.count(), indices.index_type().size());
            if !(1..=count).contains(&sparse_count) {
                return Err(Fault(format!(
                    "{element} has {sparse_count} sparse values of {count}; export it again"
                )));
            }
            self.buffers.check(&indices.view(), (indices.offset(), sparse_count, index_size), element)?;
            self.buffers.check(&values.view(), (values.offset(), sparse_count, size), element)?;
        }
        let data = |buffer: Buffer<'_>| self.buffers.get(buffer.index());
        let read: Vec<T> = Iter::new(accessor.clone(), data).into_iter().flatten().take(count).collect();
        if read.len() < count {
            return Err(Fault(format!("{element} has {} elements of {count}; export it again", read.len())));
        }
        Ok(read.into())
    }
}
