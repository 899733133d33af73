//! Writers of small meshes of two levels, as plotfiles, VTK files and hexahedra.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use isoray_amr::{Centering, Patch, Patches};
use isoray_io::{Endian, SampleType};

use crate::make::encode;

/// Lowest and highest cell.
pub(crate) type Corners = ([i32; 3], [i32; 3]);

/// The boxes of two levels; the domain of level 0 is 8 × 8 × 8 cells.
pub(crate) const BOXES: [&[Corners]; 2] = [
    &[([0, 0, 0], [3, 7, 7]), ([4, 0, 0], [7, 7, 7])],
    &[([4, 4, 4], [11, 11, 7]), ([4, 4, 8], [11, 7, 11])],
];
/// What ghost cells hold.
const GHOST: f64 = 9999.0;

/// The value of a cell or corner, which all types of floats hold exactly.
pub(crate) fn value(level: usize, component: usize, [i, j, k]: [i32; 3]) -> f64 {
    let number = 31 * i + 17 * j + 7 * k + 5 * level as i32 + 3 * component as i32;
    f64::from(number.rem_euclid(97)) + 0.25
}

fn points([low, high]: [[i32; 3]; 2]) -> impl Iterator<Item = [i32; 3]> {
    (low[2]..=high[2])
        .flat_map(move |k| (low[1]..=high[1]).flat_map(move |j| (low[0]..=high[0]).map(move |i| [i, j, k])))
}

/// The patches that a file with [`BOXES`], moved by `shift` cells of level 0, must be read as.
pub(crate) fn expected(component: usize, centering: Centering, shift: i32) -> Vec<Patch> {
    let mut patches = Vec::new();
    for (level, boxes) in BOXES.iter().enumerate() {
        for &(low, high) in *boxes {
            let low = low.map(|c| c + (shift << level));
            let high = high.map(|c| c + (shift << level));
            let cells = [0, 1, 2].map(|i| (high[i] - low[i]) as u32 + 1);
            let more = i32::from(centering == Centering::Vertices);
            let values = points([low, high.map(|c| c + more)]).map(|p| value(level, component, p) as f32);
            patches.push(Patch {
                level: level as u32,
                low,
                cells,
                values: values.collect::<Vec<_>>().into(),
            });
        }
    }
    patches
}

/// A plotfile and the variants of the format.
#[derive(Clone, Debug)]
pub(crate) struct Plotfile {
    pub(crate) first: &'static str,
    pub(crate) names: Vec<&'static str>,
    pub(crate) ratios: &'static str,
    pub(crate) sample: SampleType,
    pub(crate) endian: Endian,
    pub(crate) ghosts: [i32; 3],
    pub(crate) centering: Centering,
    /// Of `Cell_H`.
    pub(crate) version: u32,
    /// Added to all cells of level 0.
    pub(crate) shift: i32,
    /// Whether the place of the corner with index 0 is stated, or that of the domain's lowest corner.
    pub(crate) place_of_zero: bool,
}

impl Default for Plotfile {
    fn default() -> Self {
        Self {
            first: "HyperCLaw-V1.1",
            names: vec!["density", "x velocity"],
            ratios: "2",
            sample: SampleType::F64,
            endian: Endian::Little,
            ghosts: [0; 3],
            centering: Centering::Cells,
            version: 1,
            shift: 0,
            place_of_zero: true,
        }
    }
}

fn vector(v: [i32; 3]) -> String {
    format!("({},{},{})", v[0], v[1], v[2])
}

impl Plotfile {
    fn real_format(&self) -> String {
        let (bits, size) = match self.sample {
            SampleType::F64 => ("64 11 52 0 1 12 0 1023", 8),
            _ => ("32 8 23 0 1 9 0 127", 4),
        };
        let mut order: Vec<_> = (1..=size).map(|n: u32| n.to_string()).collect();
        if self.endian == Endian::Little {
            order.reverse();
        }
        format!("((8, ({bits})),({size}, ({})))", order.join(" "))
    }

    /// The box as text, with `grow` more values on both sides.
    fn typed(&self, level: usize, (low, high): Corners, grow: [i32; 3]) -> ([[i32; 3]; 2], String) {
        let more = i32::from(self.centering == Centering::Vertices);
        let low = [0, 1, 2].map(|i| low[i] + (self.shift << level) - grow[i]);
        let high = [0, 1, 2].map(|i| high[i] + (self.shift << level) + grow[i] + more);
        ([low, high], format!("({} {} {})", vector(low), vector(high), vector([more; 3])))
    }

    fn header(&self) -> String {
        let mut text = format!("{}\n{}\n{}\n", self.first, self.names.len(), self.names.join("\n"));
        // Cells of level 0 have edges of 0.5, 1 and 2.
        let low = [1.0, 2.0, 3.0];
        let high = [5.0, 10.0, 19.0];
        let domain = |level: usize| {
            let low = [self.shift << level; 3];
            let high = low.map(|c| c + (8 << level) - 1);
            format!("({} {} (0,0,0))", vector(low), vector(high))
        };
        write!(text, "3\n0.125\n1\n1 2 3\n5 10 19\n{}\n{} {}\n", self.ratios, domain(0), domain(1)).unwrap();
        text += "7 14\n0.5 1 2\n0.25 0.5 1\n0\n0\n";
        for (level, boxes) in BOXES.iter().enumerate() {
            writeln!(text, "{level} {} 0.125\n7", boxes.len()).unwrap();
            for (from, to) in *boxes {
                for i in 0..3 {
                    let edge = (high[i] - low[i]) / f64::from(8 << level);
                    let shift = if self.place_of_zero { self.shift << level } else { 0 };
                    let place = |c: i32| low[i] + edge * f64::from(c + shift);
                    writeln!(text, "{} {}", place(from[i]), place(to[i] + 1)).unwrap();
                }
            }
            writeln!(text, "Level_{level}/Cell").unwrap();
        }
        text
    }

    /// Writes the folder `name` in `dir`.
    pub(crate) fn write(&self, dir: &Path, name: &str) -> PathBuf {
        let folder = dir.join(name);
        for (level, boxes) in BOXES.iter().enumerate() {
            let inside = folder.join(format!("Level_{level}"));
            std::fs::create_dir_all(&inside).unwrap();
            let ghosts = match self.ghosts {
                [a, b, c] if a == b && b == c => a.to_string(),
                other => vector(other),
            };
            let (components, count) = (self.names.len(), boxes.len());
            let mut text = format!("{}\n1\n{components}\n{ghosts}\n({count} 0\n", self.version);
            boxes.iter().for_each(|b| writeln!(text, "{}", self.typed(level, *b, [0; 3]).1).unwrap());
            writeln!(text, ")\n{count}").unwrap();
            // Each box in a file of its own, and after another.
            for (number, corners) in boxes.iter().enumerate() {
                let mut bytes = vec![b'?'; 5 * number];
                writeln!(text, "FabOnDisk: Cell_D_0000{number} {}", bytes.len()).unwrap();
                bytes.extend(self.fab(level, *corners));
                std::fs::write(inside.join(format!("Cell_D_0000{number}")), bytes).unwrap();
            }
            write!(text, "\n{count},{components}\n1,2,\n\n{count},{components}\n3,4,\n").unwrap();
            if self.version > 1 {
                writeln!(text, "\n{}", self.real_format()).unwrap();
            }
            std::fs::write(inside.join("Cell_H"), &text).unwrap();
        }
        std::fs::write(folder.join("Header"), self.header()).unwrap();
        folder
    }

    fn fab(&self, level: usize, corners: Corners) -> Vec<u8> {
        let (grown, text) = self.typed(level, corners, self.ghosts);
        let ([low, high], _) = self.typed(level, corners, [0; 3]);
        let mut bytes = Vec::new();
        if self.version == 1 {
            bytes = format!("FAB {}{text} {}\n", self.real_format(), self.names.len()).into_bytes();
        }
        for component in 0..self.names.len() {
            for p in points(grown) {
                let inside = (0..3).all(|i| low[i] <= p[i] && p[i] <= high[i]);
                let v = if inside { value(level, component, p) } else { GHOST };
                bytes.extend(encode(v, self.sample, self.endian));
            }
        }
        bytes
    }
}

/// Replaces text in a file, which must be there once.
pub(crate) fn edit(path: &Path, old: &str, new: &str) {
    let text = std::fs::read_to_string(path).unwrap();
    assert_eq!(text.matches(old).count(), 1, "{old}");
    std::fs::write(path, text.replace(old, new)).unwrap();
}

/// A `.vti` file of a box of [`BOXES`], in text.
pub(crate) fn piece(level: usize, (low, high): Corners, centering: Centering) -> String {
    let size = [0, 1, 2].map(|i| high[i] - low[i] + 1);
    let edge = [0.5, 1.0, 2.0].map(|e| e / f64::from(1 << level));
    let place = [0, 1, 2].map(|i| [1.0, 2.0, 3.0][i] + edge[i] * f64::from(low[i]));
    let more = i32::from(centering == Centering::Vertices);
    let numbers = |component| {
        let all = points([low, high.map(|c| c + more)]).map(move |p| value(level, component, p));
        all.map(|v| v.to_string()).collect::<Vec<_>>().join(" ")
    };
    let data = if centering == Centering::Cells { "CellData" } else { "PointData" };
    let three = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
    let extent = format!("0 {} 0 {} 0 {}", size[0], size[1], size[2]);
    let marks = vec!["0"; size.iter().product::<i32>() as usize].join(" ");
    format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\"><Piece Extent=\"{extent}\">\
         <CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">{marks}</DataArray></CellData>\
         <{data}><DataArray type=\"Float64\" Name=\"density\" format=\"ascii\">{}</DataArray>\
         <DataArray type=\"Float32\" Name=\"x velocity\" format=\"ascii\">{}</DataArray></{data}>\n\
         </Piece></ImageData></VTKFile>\n",
        three(place),
        three(edge),
        numbers(0),
        numbers(1),
    )
}

/// Writes `NAME.vthb`, or in the old form `NAME.vtm`, and its pieces.
pub(crate) fn write_vtk(dir: &Path, name: &str, old: bool, centering: Centering) -> PathBuf {
    std::fs::create_dir_all(dir.join(name)).unwrap();
    let kind = if old { "vtkHierarchicalBoxDataSet" } else { "vtkOverlappingAMR" };
    let mut text =
        format!("<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" byte_order=\"LittleEndian\">\n");
    let attributes = if old { "" } else { " origin=\"1 2 3\" grid_description=\"XYZ\"" };
    writeln!(text, "<{kind}{attributes}>").unwrap();
    if old {
        text += "<RefinementRatio level=\"0\" refinement=\"2\"/>\n";
    }
    for (level, boxes) in BOXES.iter().enumerate() {
        if !old {
            let spacing = ["0.5 1 2", "0.25 0.5 1"][level];
            writeln!(text, "<Block level=\"{level}\" spacing=\"{spacing}\">").unwrap();
        }
        for (number, &(low, high)) in boxes.iter().enumerate() {
            let file = format!("{name}/{level}_{number}.vti");
            std::fs::write(dir.join(&file), piece(level, (low, high), centering)).unwrap();
            let corners = [0, 1, 2].map(|i| format!("{} {}", low[i], high[i])).join(" ");
            let index = if old {
                format!("group=\"{level}\" dataset=\"{number}\"")
            } else {
                format!("index=\"{number}\"")
            };
            writeln!(text, "<DataSet {index} amr_box=\"{corners}\" file=\"{file}\"/>").unwrap();
        }
        if !old {
            text += "</Block>\n";
        }
    }
    if !old {
        text += "<Block level=\"2\" spacing=\"0.125 0.25 0.5\"/>\n";
    }
    write!(text, "</{kind}>\n</VTKFile>\n").unwrap();
    let path = dir.join(format!("{name}.{}", if old { "vtm" } else { "vthb" }));
    std::fs::write(&path, text).unwrap();
    path
}

/// An octree as hexahedra: cells of edge 2, of which the first is split in eight.
#[derive(Clone, Debug)]
pub(crate) struct Hexahedra {
    pub(crate) ascii: bool,
    /// 2, 4 or 5.
    pub(crate) version: u32,
    /// Type of coordinates and values.
    pub(crate) sample: SampleType,
    /// Voxels, whose corners are in another order.
    pub(crate) voxels: bool,
    pub(crate) scale: f64,
}

/// Lowest corner and edge of each cell: 2 × 1 × 1 large cells, the first of them split.
pub(crate) fn leaves() -> Vec<([i32; 3], i32)> {
    let small = points([[0; 3], [1; 3]]).map(|p| (p, 1));
    small.chain([([2, 0, 0], 2)]).collect()
}

impl Hexahedra {
    pub(crate) fn new(ascii: bool) -> Self {
        Self { ascii, version: 2, sample: SampleType::F32, voxels: false, scale: 0.5 }
    }

    fn numbers(&self, numbers: &[f64], sample: SampleType) -> Vec<u8> {
        if self.ascii {
            return numbers.iter().map(|v| format!("{v} ")).collect::<String>().into_bytes();
        }
        numbers.iter().flat_map(|&v| encode(v, sample, Endian::Big)).collect()
    }

    /// Points are those of a lattice of 5 × 3 × 3, whether used or not; the first is at (-1, 0.25, 3).
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let corner = |[i, j, k]: [i32; 3]| i + 5 * (j + 3 * k);
        let cells: Vec<Vec<f64>> = leaves()
            .iter()
            .map(|&([x, y, z], e)| {
                let at = |i, j, k| f64::from(corner([x + e * i, y + e * j, z + e * k]));
                let [mut a, mut b] = [0, 1].map(|k| [at(0, 0, k), at(1, 0, k), at(1, 1, k), at(0, 1, k)]);
                if self.voxels {
                    a.swap(2, 3);
                    b.swap(2, 3);
                }
                [a, b].concat()
            })
            .collect();
        let origin = [-1.0, 0.25, 3.0];
        let places: Vec<f64> = points([[0; 3], [4, 2, 2]])
            .flat_map(|p| [0, 1, 2].map(|i| origin[i] + self.scale * f64::from(p[i])))
            .collect();
        let kind = if self.sample == SampleType::F64 { "double" } else { "float" };
        let (encoding, count) = (if self.ascii { "ASCII" } else { "BINARY" }, cells.len());
        let mut bytes = format!(
            "# vtk DataFile Version {}.0\noctree\n{encoding}\nDATASET UNSTRUCTURED_GRID\nPOINTS 45 {kind}\n",
            self.version
        )
        .into_bytes();
        bytes.extend(self.numbers(&places, self.sample));
        if self.version < 5 {
            bytes.extend(format!("\nCELLS {count} {}\n", 9 * count).bytes());
            let counted: Vec<f64> = cells.iter().flat_map(|c| [vec![8.0], c.clone()].concat()).collect();
            bytes.extend(self.numbers(&counted, SampleType::I32));
        } else {
            let ends: Vec<f64> = (0..=count).map(|n| 8.0 * n as f64).collect();
            bytes.extend(format!("\nCELLS {} {}\nOFFSETS vtktypeint64\n", count + 1, 8 * count).bytes());
            bytes.extend(self.numbers(&ends, SampleType::I64));
            bytes.extend(b"\nCONNECTIVITY vtktypeint64\n");
            bytes.extend(self.numbers(&cells.concat(), SampleType::I64));
        }
        bytes.extend(format!("\nCELL_TYPES {count}\n").bytes());
        bytes.extend(self.numbers(&vec![if self.voxels { 11.0 } else { 12.0 }; count], SampleType::I32));
        let values =
            |component| -> Vec<f64> { points([[0; 3], [4, 2, 2]]).map(|p| value(0, component, p)).collect() };
        bytes.extend(format!("\nPOINT_DATA 45\nSCALARS T {kind}\nLOOKUP_TABLE default\n").bytes());
        bytes.extend(self.numbers(&values(0), self.sample));
        let v: Vec<f64> = (0..45).flat_map(|p| [1, 2, 3].map(|c| values(c)[p])).collect();
        bytes.extend(format!("\nVECTORS U {kind}\n").bytes());
        bytes.extend(self.numbers(&v, self.sample));
        bytes.extend(format!("\nCELL_DATA {count}\nSCALARS number int\nLOOKUP_TABLE default\n").bytes());
        let numbers: Vec<f64> = (0..count).map(|n| n as f64).collect();
        bytes.extend(self.numbers(&numbers, SampleType::I32));
        bytes.push(b'\n');
        bytes
    }

    /// What must be read: of `T`, a component of `U`, or, without a component, the numbers of cells.
    pub(crate) fn expected(component: Option<usize>) -> Vec<Patch> {
        let patch = |(number, ([x, y, z], e)): (usize, ([i32; 3], i32))| {
            let corners = points([[0; 3], [1; 3]]).map(|[i, j, k]| [x + e * i, y + e * j, z + e * k]);
            let values = match component {
                Some(component) => corners.map(|p| value(0, component, p) as f32).collect::<Vec<_>>(),
                None => vec![number as f32],
            };
            Patch {
                level: u32::from(e == 1),
                low: [x, y, z].map(|c| c / e),
                cells: [1; 3],
                values: values.into(),
            }
        };
        leaves().into_iter().enumerate().map(patch).collect()
    }
}

/// Checks everything of a mesh with [`BOXES`] but its patches.
pub(crate) fn check_outline(patches: &Patches, centering: Centering, shift: i32) {
    assert_eq!((patches.centering, &patches.ratios[..]), (centering, &[2][..]));
    assert_eq!(patches.domain, ([shift; 3], [8; 3]));
}
