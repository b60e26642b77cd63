#!/usr/bin/env python3
"""Writes the fuzzers' seeds: tests/fuzz/corpus/<parser>/*, small files of every kind that a parser knows.

usage: tests/fuzz/make_seeds.py      (needs Pillow, for JPEG)

Inputs by which a fuzzer found faults, mended since, lie there too, under names that begin with "found_"; they stay.
"""
import base64
import gzip
import io
import json
import math
import struct
import zlib
from pathlib import Path

from PIL import Image, ImageCms

CORPUS = Path(__file__).parent / 'corpus'


def write(parser, name, content):
    folder = CORPUS / parser
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def as_json(value):
    return json.dumps(value) + '\n'


# --- Splats of other programs: two, at (0.5, -1, 2) and (0, 0, 0), turned by 60 degrees about x. ---

AXES = 0xadbe0003, 4, 6  # the extension that says in which axes they are: 6, right, down, forward
OTHER = 0x12340001, 4, 1


def spz(version, count=2, zipped=True, size=None, extension=None):
    positions = [0.5, -1.0, 2.0, 0.0, 0.0, 0.0] if not extension else [0.5, 1.0, -2.0, 0.0, 0.0, 0.0]
    if version == 1:
        data = struct.pack('<6e', *positions)
        rotation = bytes([191, 128, 128])
    else:
        data = b''.join(struct.pack('<i', round(p * 4096))[:3] for p in positions)
        rotation = bytes([191, 128, 128]) if version == 2 else struct.pack('<I', 3 << 30 | 361 << 20)
    data += bytes([204, 51]) + 2 * bytes([166, 128, 90]) + 2 * bytes([96, 96, 80]) + 2 * rotation
    if extension:  # behind harmonics of one degree
        data += bytes(2 * 9) + struct.pack('<6I', *OTHER, *extension)
    header = struct.pack('<IIIBBBB', 0x5053474e, version, count, 1 if extension else 0, 12, 2 if extension else 0, 0)
    return gzip.compress((header + data)[:size], mtime=0) if zipped else header + data


def zstd_stored(data):
    """A frame of Zstandard (RFC 8878) with its size and one block that is stored as it is."""
    return struct.pack('<IBI', 0xfd2fb528, 0xa0, len(data)) + struct.pack('<I', 1 | len(data) << 3)[:3] + data


def spz4(count=2, cut=0, harmonics=0, extension=None):
    """By the format's description (github.com/nianticlabs/spz, README)."""
    parts = [b''.join(struct.pack('<i', round(p * 4096))[:3] for p in ((0.5, 1.0, -2.0) if extension else (0.5, -1.0, 2.0)) + (0, 0, 0)),
             bytes([204, 51]), 2 * bytes([166, 128, 90]), 2 * bytes([96, 96, 80]), 2 * struct.pack('<I', 3 << 30 | 361 << 20)]
    if harmonics:
        parts.append(bytes(2 * 9))
    streams = [zstd_stored(part) for part in parts]
    records = struct.pack('<6I', *OTHER, *extension) if extension else b''
    header = struct.pack('<IIIBBBBI12x', 0x5053474e, 4, count, harmonics, 12, 2 if extension else 0, len(streams), 32 + len(records))
    table = b''.join(struct.pack('<QQ', len(stream), len(part)) for stream, part in zip(streams, parts))
    whole = header + records + table + b''.join(streams)
    return whole[:len(whole) - cut]


def dot_splat():
    half = math.sqrt(0.75)
    rows = [(0.5, -1, 2, 204), (0, 0, 0, 51)]
    return b''.join(struct.pack('<6f8B', *row[:3], math.exp(-4), math.exp(-4), math.exp(-5), 199, 128, 56, row[3],
                                round(half * 128) + 128, 192, 128, 128) for row in rows)


def gltf_splats(binary, extension='KHR_gaussian_splatting', space='srgb_rec709_display', moved='', times=1, size=math.exp(-4), uri='',
                how=None, change=None, packed=b''):
    half, dc = math.sqrt(0.75), 1.0
    columns = {
        'POSITION': ([0.5, -1, 2, 0, 0, 0], 'VEC3'),
        'KHR_gaussian_splatting:ROTATION': (2 * [0.5, 0, 0, half], 'VEC4'),
        'KHR_gaussian_splatting:SCALE': (2 * [size, math.exp(-4), math.exp(-5)], 'VEC3'),
        'KHR_gaussian_splatting:SH_DEGREE_0_COEF_0': (2 * [dc, 0, -dc], 'VEC3'),
    }
    data, views, accessors, attributes = b'', [], [], {}

    def add(name, content, kind, **more):
        nonlocal data
        attributes[name] = len(accessors)
        views.append({'buffer': 0, 'byteOffset': len(data), 'byteLength': len(content)})
        accessors.append({'bufferView': len(views) - 1, 'count': 2, 'type': kind, **more})
        data += content + bytes(-len(content) % 4)

    for name, (values, kind) in columns.items():
        add(name, struct.pack(f'<{len(values)}f', *values), kind, componentType=5126)
    add('KHR_gaussian_splatting:OPACITY', bytes([204, 51]), 'SCALAR', componentType=5121, normalized=True)
    if packed:
        views.append({'buffer': 0, 'byteOffset': len(data), 'byteLength': len(packed)})
        data += packed + bytes(-len(packed) % 4)
        for accessor in accessors:
            del accessor['bufferView']
    primitive = {'mode': 0, 'attributes': attributes, 'extensions': {extension: {'colorSpace': space, **(how or {})}}}
    root = {'asset': {'version': '2.0'}, 'bufferViews': views, 'accessors': accessors,
            'meshes': [{'primitives': times * [primitive]}], 'buffers': [{'byteLength': len(data)}],
            'nodes': [{'mesh': 0}, {'children': [0]}, {'camera': 0}]}
    if moved:
        root['nodes'][{'splats': 0, 'parent': 1, 'camera': 2}[moved]]['translation'] = [1, 0, 0]
    if moved == 'parent':  # by columns: x to y, y to z, z to x, all twice as large
        root['nodes'][0]['matrix'] = [0, 2, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0, 0, 0, 1]
        root['nodes'][1]['scale'] = [1, 1, -3]
    if change:
        change(root)
    if uri:
        root['buffers'][0]['uri'] = uri
        return as_json(root), data
    if not binary:
        root['buffers'][0]['uri'] = 'data:application/octet-stream;base64,' + base64.b64encode(data).decode()
        return as_json(root)
    text = json.dumps(root).encode()
    text += b' ' * (-len(text) % 4)
    chunks = b''.join(struct.pack('<II', len(c), k) + c for k, c in ((0x4e4f534a, text), (0x004e4942, data)))
    return struct.pack('<III', 0x46546c67, 2, 12 + len(chunks)) + chunks


def splats():
    for version in (1, 2, 3, 4):
        write('spz', f'version{version}.spz', spz(version))
    write('spz', 'streams.spz', spz4())
    write('spz', 'harmonics.spz', spz4(harmonics=1))
    write('spz', 'streams_short.spz', spz4(cut=1))
    write('spz', 'streams_many.spz', spz4(count=40000000))
    write('splat', 'two.splat', dot_splat())
    write('spz', 'short.spz', spz(2, size=40))
    write('spz', 'many.spz', spz(2, count=40000000))
    write('spz', 'plain.spz', spz(3, zipped=False))
    write('spz', 'axes.spz', spz4(extension=AXES))
    write('spz', 'axes_zipped.spz', spz(3, extension=AXES))
    write('spz', 'axes_plain.spz', spz(2, zipped=False, extension=AXES))
    write('gltf', 'splats.glb', gltf_splats(True))
    write('gltf', 'splats.gltf', gltf_splats(False))
    write('gltf', 'linear.glb', gltf_splats(True, space='lin_rec709_display'))
    write('gltf', 'moved.glb', gltf_splats(True, moved='splats'))
    write('gltf', 'carried.glb', gltf_splats(True, moved='parent'))
    write('gltf', 'camera.glb', gltf_splats(True, moved='camera'))
    write('gltf', 'twice.glb', gltf_splats(True, times=2))
    write('gltf', 'mixed.glb', gltf_splats(True, change=lambda root: root['meshes'][0]['primitives'].append({'attributes': {'POSITION': 0}})))
    write('gltf', 'size.glb', gltf_splats(True, size=math.nan))
    write('gltf', 'none.glb', gltf_splats(True, extension='KHR_other'))
    write('gltf', 'thin.glb', gltf_splats(True, size=0))
    write('gltf', 'negative.glb', gltf_splats(True, size=-1))
    packing = 'KHR_gaussian_splatting_compression_spz_2'
    write('gltf', 'packed.glb', gltf_splats(True, how={'extensions': {packing: {'bufferView': 5}}}, packed=spz(3)))
    write('gltf', 'packed_nowhere.glb', gltf_splats(True, how={'extensions': {packing: {'bufferView': 5}}}))
    write('gltf', 'packed_else.glb', gltf_splats(True, how={'extensions': {'EXT_other_compression': {}}}))
    write('gltf', 'kernel.glb', gltf_splats(True, how={'kernel': 'customShape', 'extensions': {'EXT_kernel_customShape': {}}}))
    twice = {'nodes': [{'mesh': 0}, {'mesh': 0}], 'scenes': [{'nodes': [1]}, {'nodes': [0]}], 'scene': 1}
    write('gltf', 'hidden.glb', gltf_splats(True, change=lambda root: root.update(twice)))
    write('gltf', 'meshopt.glb', gltf_splats(True, change=lambda root: root.update(extensionsRequired=['EXT_meshopt_compression'])))

    def stand_in(root):
        root['buffers'].append({'byteLength': root['buffers'][0]['byteLength']})
        for view in root['bufferViews']:
            view['buffer'] = 1

    write('gltf', 'stand_in.glb', gltf_splats(True, change=stand_in))
    write('gltf', 'sparse.glb', gltf_splats(True, change=lambda root: root['accessors'][0].update(sparse={'count': 1})))
    text, data = gltf_splats(False, uri='parts/a%2Cb.bin')
    write('gltf', 'beside.gltf', text)
    write('gltf/parts', 'a,b.bin', data)
    write('gltf', 'above.gltf', gltf_splats(False, uri='parts/%2e%2e/%2e./a.bin')[0])


# --- Pictures. ---

def png(colour, depth, interlaced=False, extra=b'', side=4):
    """Of any colour type and depth. Interlaced, it is 1 x 1, which is in the first of the seven passes."""
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    side = 1 if interlaced else side
    row = bytes((37 * i) % 256 for i in range((side * channels * depth + 7) // 8))
    if colour == 3:
        row = bytes(len(row))  # only the palette's first entry

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))

    header = struct.pack('>IIBBBBB', side, side, depth, colour, 0, 0, int(interlaced))
    pixels = b''.join(bytes([y % 5]) + row for y in range(side))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + extra_chunks(extra, chunk) +
            chunk(b'IDAT', zlib.compress(pixels)) + chunk(b'IEND', b''))


def extra_chunks(extra, chunk):
    return b''.join(chunk(kind, data) for kind, data in extra or [])


def pngs():
    for colour, depths in {0: (1, 2, 4, 8, 16), 2: (8, 16), 4: (8, 16), 6: (8, 16)}.items():
        for depth in depths:
            write('png', f'colour{colour}_{depth}.png', png(colour, depth))
    palette = [(b'PLTE', bytes(range(12)))]
    for depth in (1, 8):
        write('png', f'palette_{depth}.png', png(3, depth, extra=palette))
    write('png', 'palette_alpha.png', png(3, 4, extra=palette + [(b'tRNS', b'\x80\x40')]))
    write('png', 'key.png', png(2, 8, extra=[(b'tRNS', bytes(6)), (b'gAMA', struct.pack('>I', 45455))]))
    write('png', 'interlaced.png', png(6, 8, interlaced=True))
    write('png', 'text.png', png(0, 8, extra=[(b'tEXt', b'Comment\0words'), (b'pHYs', bytes(9))]))


def jpegs():
    colours = Image.new('RGB', (16, 8), (200, 90, 20))
    colours.putpixel((3, 3), (0, 255, 0))
    kinds = {
        'colour': (colours, {}), 'fine': (colours, {'subsampling': 0, 'quality': 95}),
        'progressive': (colours, {'progressive': True}), 'grey': (colours.convert('L'), {}),
        'cmyk': (colours.convert('CMYK'), {}), 'restart': (colours, {'restart_marker_blocks': 1}),
        'comment': (colours, {'comment': b'words'}),
    }
    for orientation in (3, 6):
        exif = Image.Exif()
        exif[0x0112] = orientation
        kinds[f'exif{orientation}'] = (colours, {'exif': exif})
    for name, (image, options) in kinds.items():
        out = io.BytesIO()
        image.save(out, 'JPEG', **options)
        write('jpeg', name + '.jpg', out.getvalue())


def profiles():
    icc = ImageCms.ImageCmsProfile(ImageCms.createProfile('sRGB')).tobytes()
    icc = icc[:24] + bytes(12) + icc[36:]  # without the date
    named = b'words\0\0' + zlib.compress(icc)
    write('profile', 'iccp.png', png(2, 8, extra=[(b'iCCP', named)]))
    write('profile', 'cicp.png', png(2, 8, extra=[(b'cICP', bytes([12, 13, 0, 1]))]))
    write('profile', 'gama.png', png(2, 8, extra=[(b'gAMA', struct.pack('>I', 100000)), (b'cHRM', struct.pack(
        '>8I', 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000))]))
    write('profile', 'iccp.webp', b'RIFF....WEBPVP8X\x0a\0\0\0\x20' + bytes(9) + b'ICCP' + struct.pack('<I', len(icc)) + icc)
    half = len(icc) // 2
    parts = [b'ICC_PROFILE\0' + bytes([i + 1, 2]) + part for i, part in enumerate((icc[:half], icc[half:]))]
    write('profile', 'two.jpg', b'\xff\xd8' + b''.join(b'\xff\xe2' + struct.pack('>H', len(part) + 2) + part for part in parts) +
          b'\xff\xda\0\2')


def tiff(channels, bits, compression=1, order='<', photometric=None, tile=0, width=5, height=4, **more):
    """Little or big endian, of one strip or one tile; `more`: further tags, as tag_<number>=value."""
    side = (tile, tile) if tile else (width, height)
    data = bytes((31 * i) % 256 for i in range(side[0] * side[1] * channels * bits // 8))
    if bits == 32:
        data = struct.pack(order + 'f', 0.5) * (len(data) // 4)
    packed = zlib.compress(data) if compression == 8 else data
    colours = 2 if channels >= 3 else 1
    tags = {256: width, 257: height, 258: bits, 259: compression, 262: colours if photometric is None else photometric,
            277: channels, 339: 3 if bits == 32 else 1}
    tags.update({322: tile, 323: tile, 324: 8, 325: len(packed)} if tile else {273: 8, 278: height, 279: len(packed)})
    tags.update({int(name[4:]): value for name, value in more.items()})
    entries = b''.join(struct.pack(order + 'HHII', tag, 4, 1, value) if tag in (273, 279, 324, 325) else
                       struct.pack(order + 'HHIHxx', tag, 3, 1, value) for tag, value in sorted(tags.items()))
    padding = bytes(len(packed) % 2)
    return ((b'II*\0' if order == '<' else b'MM\0*') + struct.pack(order + 'I', 8 + len(packed) + len(padding)) + packed +
            padding + struct.pack(order + 'H', len(tags)) + entries + bytes(4))


def tiffs():
    for channels in (1, 2, 3, 4):
        for bits in (8, 16, 32):
            write('tiff', f'channels{channels}_{bits}.tif', tiff(channels, bits, 8 if bits == 8 else 1, '<>'[channels % 2]))
    write('tiff', 'tiled.tif', tiff(3, 8, 8, tile=16, tag_274=6))
    write('tiff', 'planes.tif', tiff(1, 16, tag_274=3, tag_284=2))
    write('tiff', 'negative.tif', tiff(1, 8, photometric=0))
    write('tiff', 'premultiplied.tif', tiff(4, 8, tag_338=1))
    write('tiff', 'raw.tif', tiff(1, 16, photometric=32803))
    for name, compression in (('lzw', 'tiff_lzw'), ('packbits', 'packbits'), ('jpeg', 'jpeg')):
        out = io.BytesIO()
        Image.new('RGB', (16, 8), (200, 90, 20)).save(out, 'TIFF', compression=compression)
        write('tiff', name + '.tif', out.getvalue())


def exr(channels, compression=0, half=False, tiled=False, side=4, compress=lambda data: data):
    def attribute(name, kind, data):
        return name.encode() + b'\0' + kind.encode() + b'\0' + struct.pack('<i', len(data)) + data

    listed = b''.join(c.encode() + b'\0' + struct.pack('<iBxxxii', 1 if half else 2, 0, 1, 1)
                      for c in sorted(channels)) + b'\0'
    window = struct.pack('<iiii', 0, 0, side - 1, side - 1)
    header = (attribute('channels', 'chlist', listed) + attribute('compression', 'compression', bytes([compression])) +
              attribute('dataWindow', 'box2i', window) + attribute('displayWindow', 'box2i', window) +
              attribute('lineOrder', 'lineOrder', b'\0') + attribute('pixelAspectRatio', 'float', struct.pack('<f', 1)) +
              attribute('screenWindowCenter', 'v2f', bytes(8)) + attribute('screenWindowWidth', 'float', struct.pack('<f', 1)))
    if tiled:
        header += attribute('tiles', 'tiledesc', struct.pack('<IIB', side, side, 0))
    start = struct.pack('<II', 20000630, 0x202 if tiled else 2) + header + b'\0'
    lines = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}[compression]
    lines = side if tiled else lines
    values = struct.pack('<e' if half else '<f', 0.5) * side * len(channels)
    chunks = []
    for y in range(0, side, lines):
        data = values * min(lines, side - y)
        packed = compress(data)
        packed = packed if len(packed) < len(data) else data
        place = struct.pack('<iiii', 0, 0, 0, 0) if tiled else struct.pack('<i', y)
        chunks.append(place + struct.pack('<i', len(packed)) + packed)
    offset, table = len(start) + 8 * len(chunks), b''
    for chunk in chunks:
        table += struct.pack('<Q', offset)
        offset += len(chunk)
    return start + table + b''.join(chunks)


def zip_of_exr(data):
    apart = data[0::2] + data[1::2]
    deltas = apart[:1] + bytes((b - a + 128) % 256 for a, b in zip(apart, apart[1:]))
    return zlib.compress(deltas)


def exrs():
    write('exr', 'rgb.exr', exr('RGB'))
    write('exr', 'rgba_half.exr', exr('RGBA', half=True))
    write('exr', 'grey.exr', exr('Y'))
    write('exr', 'depth_zip.exr', exr('Z', 3, side=8, compress=zip_of_exr))
    write('exr', 'rgb_zips.exr', exr('RGB', 2, side=8, compress=zip_of_exr))
    for compression in (1, 4, 5, 6, 7, 8, 9):  # whose blocks are stored when packing does not pay
        write('exr', f'rgb_{compression}.exr', exr('RGB', compression, half=compression in (6, 7)))
    write('exr', 'tiled.exr', exr('RGB', tiled=True))
    write('exr', 'layers.exr', exr(['a.Combined.R', 'a.Combined.G', 'a.Combined.B', 'a.Depth.Z', 'b.R', 'b.G', 'b.B']))


# --- Gaussians and tensors. ---

def plys():
    names = ('x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3 '
             'base_color_0 base_color_1 base_color_2 roughness').split()
    row = [0.1, 0.2, 0.3, 0, 0, 0, 1, -3, -3, -3, 1, 0, 0, 0, 0, 0, 0, 0.5]
    for count, kind, code in ((2, 'float', 'f'), (1, 'double', 'd'), (0, 'float', 'f')):
        head = f'ply\nformat binary_little_endian 1.0\ncomment words\nelement vertex {count}\n'
        head += ''.join(f'property {kind} {name}\n' for name in names) + 'end_header\n'
        write('ply', f'{count}_{kind}.ply', head.encode() + struct.pack('<' + code * len(row), *row) * count)
    head = 'ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\nproperty uchar other\r\n'
    head += ''.join(f'property float {name}\r\n' for name in reversed(names)) + 'end_header\r\n'
    write('ply', 'other_order.ply', head.encode() + b'\0' + struct.pack('<18f', *reversed(row)))


def foreign_plys():
    """The two splats of splats(), in the encodings and layouts of other programs."""
    half, shape = math.sqrt(0.75), [-4, -4, -5]
    names = 'x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3'.split()
    rows = [[*at, 1, 0, -1, logit, *shape, half, 0.5, 0, 0] for at, logit in (((0.5, -1, 2), math.log(4)), ((0, 0, 0), -math.log(4)))]
    properties = ''.join(f'property float {name}\n' for name in names)

    def head(encoding, before='', more='', after='', rest=properties):
        return f'ply\nformat {encoding} 1.0\n{before}element vertex 2\n{rest}{more}{after}end_header\n'

    ascii_rows = ''.join(' '.join(f'{value:.9g}' for value in row) + '\n' for row in rows)
    write('ply', 'ascii.ply', head('ascii') + ascii_rows)
    write('ply', 'loose.ply', head('ascii', before=f'comment {"settings " * 200}\n \t\n').replace('\n', ' \r\n') + ascii_rows)
    write('ply', 'ascii_short.ply', head('ascii') + ascii_rows[:-4])
    write('ply', 'ascii_word.ply', head('ascii') + ascii_rows.replace('-4', 'four', 1))
    write('ply', 'big.ply', head('binary_big_endian').encode() + b''.join(struct.pack('>14f', *row) for row in rows))
    lists = b''.join(struct.pack('<14fB3i', *row, 3, 1, 2, 3) for row in rows)
    camera = 'element camera 1\nproperty float view_px\nproperty list uint8 float k\n'
    faces = 'element face 1\nproperty list uchar int vertex_indices\n'
    write('ply', 'elements.ply', head('binary_little_endian', camera, 'property list uchar int ids\n', faces).encode() +
          struct.pack('<fB2f', 1, 2, 3, 4) + lists + struct.pack('<B3i', 3, 0, 1, 0))
    coloured = ''.join(f'property {"uchar" if name in ("red", "green", "blue") else "float"} {name}\n'
                       for name in [*names[:3], 'red', 'green', 'blue', *names[6:]])
    colours = [round(255 * (0.5 + 0.28209479 * dc)) for dc in (1, 0, -1)]
    write('ply', 'coloured.ply', head('binary_little_endian', rest=coloured).encode() +
          b''.join(struct.pack('<3f3B8f', *row[:3], *colours, *row[6:]) for row in rows))
    points = ''.join(f'property float {name}\n' for name in names[:3])
    at = struct.pack('<6f', 0.5, -1, 2, 0, 0, 0)
    write('ply', 'points.ply', head('binary_little_endian', rest=points).encode() + at)
    write('ply', 'mesh.ply', head('binary_little_endian', after=faces, rest=points).encode() + at + struct.pack('<B3i', 3, 0, 1, 0))
    write('ply', 'discs.ply', head('ascii').replace('property float scale_2\n', '') +
          ''.join(' '.join(f'{v:.9g}' for i, v in enumerate(row) if i != 9) + '\n' for row in rows))
    extra = 'property float f_rest_0\nproperty float f_rest_1\nproperty float filter_3D\n'
    for name, rest in (('harmonics', '0 0.25 0'), ('no_harmonics', '0 0 0')):
        write('ply', name + '.ply', head('ascii', more=extra) + ''.join(line + ' ' + rest + '\n' for line in ascii_rows.splitlines()))
    compressed(head, faces)


def compressed(head, faces):
    """SuperSplat's compressed PLY: bounds for 256 splats each, between which whole numbers lie; here of both splats' own."""
    bounds = ([0, -1.023, 0], [2.047, 0, 2.047], [-6, -5.023, -6], [-3.953, -4, -3.953], [0, 0, 0], [1, 1, 1])
    names = [f'{end}_{what}' for what in ('{}', 'scale_{}') for end in ('min', 'max') for what in [what]]
    columns = [name.format(axis) for name in names for axis in 'xyz'] + [f'{end}_{c}' for end in ('min', 'max') for c in 'rgb']
    chunk = 'element chunk 1\n' + ''.join(f'property float {name}\n' for name in columns)
    packed = ''.join(f'property uint packed_{name}\n' for name in ('position', 'rotation', 'scale', 'color'))
    colour, shape = 199 << 24 | 128 << 16 | 56 << 8, 2000 << 21 | 1023 << 11 | 1000

    def turned(*wxyz):
        largest = max(range(4), key=lambda i: abs(wxyz[i]))
        small = [round((part / math.sqrt(2) + 0.5) * 1023) for i, part in enumerate(wxyz) if i != largest]
        return largest << 30 | small[0] << 20 | small[1] << 10 | small[2]

    at, origin = 500 << 21 | 23 << 11 | 2000, 1023 << 11
    rows = [(at, turned(math.sqrt(0.75), 0.5, 0, 0), shape, colour | 204), (origin, turned(math.sqrt(0.75), 0.5, 0, 0), shape, colour | 51)]
    others = [(at, turned(0.1, 0.3, 0.9, -0.3), shape, colour | 255), (at, turned(-0.1, 0.3, 0.3, 0.9), shape, colour)]
    for name, those in (('compressed', rows), ('turned', others)):
        data = struct.pack('<18f', *(value for bound in bounds for value in bound)) + b''.join(struct.pack('<4I', *row) for row in those)
        write('ply', name + '.ply', head('binary_little_endian', chunk, rest=packed).encode() + data)
    none = chunk.replace('chunk 1', 'chunk 0')
    write('ply', 'no_chunk.ply', head('binary_little_endian', none, rest=packed).encode() + data[72:])


def safetensors():
    def packed(header, data=b''):
        text = as_json(header).encode()
        return struct.pack('<Q', len(text)) + text + data

    sizes = {'F32': 4, 'BF16': 2, 'F16': 2, 'F64': 8, 'I64': 8, 'U8': 1}
    header, offset = {'__metadata__': {'key': 'value'}}, 0
    for kind, size in sizes.items():
        header[kind] = {'dtype': kind, 'shape': [1, 2], 'data_offsets': [offset, offset + 2 * size]}
        offset += 2 * size
    write('safetensors', 'kinds.safetensors', packed(header, bytes(offset)))
    write('safetensors', 'empty.safetensors', packed({'none': {'dtype': 'F32', 'shape': [0], 'data_offsets': [0, 0]}}))
    model = {'format': 'ffprocams-model', 'format_version': '1', 'model.name': 'tiny', 'model.modules': 'MT',
             'model.dim': '64', 'model.patch': '8', 'model.state': '64', 'model.chunk': '64',
             'model.residual': 'true', 'model.match_input': 'true', 'model.pixel_skip': 'true',
             'model.pixel_features': '8', 'model.pixel_hidden': '32', 'model.render': 'ours',
             'model.tokens': '4096', 'model.samples': '2', 'model.context_inputs': 'true'}
    write('safetensors', 'model.safetensors', packed({'__metadata__': model}))


# --- Captures. ---

C2W = [[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
P2W = [[0, 0, -1, 2], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
BLENDER = [[0, 0, 1, 3], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]


def scene():
    return {
        'format': 'ffprocams-capture', 'version': 1, 'name': 'seed', 'depth_scale': 1,
        'object': {'centre': [0, 0, 0], 'radius': 0.95},
        'camera': {'width': 8, 'height': 8, 'fx': 9, 'fy': 9, 'cx': 4, 'cy': 4},
        'projector': {'width': 4, 'height': 4, 'fx': 5, 'fy': 5, 'cx': 2, 'cy': 2, 'intensity': [8, 8, 8]},
        'patterns': [{'name': 'black', 'role': 'black'}, {'name': 'white', 'role': 'white'},
                     {'name': 'dots', 'file': 'patterns/dots.png', 'role': 'active'}],
        'views': [{'id': '000', 'c2w': C2W, 'p2w': P2W, 'depth': 'a_depth.png', 'coverage': 'a_mask.png',
                   'images': {'black': 'a.png', 'white': 'b.png', 'dots': 'c.png'}}],
    }


def poses():
    view = {'view_id': 'a', 'c2w': BLENDER, 'p2w': BLENDER, 'proj_fx': 5, 'proj_fy': 5, 'proj_cx': 2, 'proj_cy': 2,
            'patterns': [{'file_path': 'elsewhere/a.png', 'projector_image': 'black'},
                         {'file_path': 'b.png', 'projector_image': 'white'},
                         {'file_path': 'c.png', 'projector_image': 'dots'}]}
    return {'scene_name': 'seed', 'camera': {'w': 8, 'h': 8, 'fx': 9, 'fy': 9, 'cx': 4, 'cy': 4},
            'projector': {'pattern_w': 4, 'pattern_h': 4, 'projector_energy': 100}, 'views': [view]}


def captures():
    write('scene', 'whole.json', as_json(scene()))
    bare = scene()
    for key in ('name', 'object', 'depth_scale'):
        del bare[key]
    del bare['projector']['intensity']
    for key in ('depth', 'coverage'):
        del bare['views'][0][key]
    bare['views'][0]['camera'] = {'fx': 10}
    write('scene', 'bare.json', as_json(bare))
    novel = scene()
    novel['patterns'][2]['role'] = 'novel'
    write('scene', 'novel.json', as_json(novel))
    truth = scene()
    truth['views'][0].update({'albedo': 'a.png', 'roughness': 'a_mask.png', 'direct_white': 'b.png'})
    write('scene', 'truth.json', as_json(truth))
    real = scene()
    real['projector']['device'] = {'width': 8, 'height': 6, 'fx': 10, 'fy': 10, 'cx': 4, 'cy': 6,
                                   'lens': [0.1, -0.1, 0, 0.01, 0], 'gamma': [2.2, 2, 1]}
    write('scene', 'device.json', as_json(real))

    write('render_poses', 'whole.json', as_json(poses()))
    bare = poses()
    del bare['projector'], bare['scene_name']
    write('render_poses', 'bare.json', as_json(bare))
    lollipop = poses()
    lollipop['views'][0]['patterns'][2]['projector_image'] = 'lollipop_0'
    write('render_poses', 'lollipop.json', as_json(lollipop))

    targets = scene()
    targets['views'] = [{'id': 'new', 'c2w': C2W, 'p2w': P2W}]
    write('targets', 'scene.json', as_json(targets))
    write('targets', 'pictures.json', as_json(scene()))
    del targets['patterns']
    write('targets', 'bare.json', as_json(targets))
    targets = poses()
    del targets['views'][0]['patterns']
    write('targets', 'poses.json', as_json(targets))


def configurations():
    write('train_config', 'empty.json', '{}\n')
    write('train_config', 'run.json', as_json({
        'model': 'tiny', 'seed': 1, 'steps': 500, 'resolution': 64, 'pool': 1, 'reuse': 1000000, 'views': 8, 'targets': 0,
        'lollipops': 2, 'supervised_inputs': 4, 'supervised_targets': 0, 'learning_rate': 3e-3, 'l1': 1, 'ssim': 0}))
    write('train_config', 'model.json', as_json({
        'model': {'preset': 'small', 'dim': 128, 'modules': 'MT', 'residual': False, 'pixel_skip': False,
                  'render': 'paper', 'samples': 1}, 'views_least': 4, 'free_share': 0.5, 'scenes': ''}))


# --- Calibrations. ---

K = [[9, 0, 4], [0, 9, 4], [0, 0, 1]]
UNIT = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def opencv_yaml(names, sizes=''):
    def matrix(name, rows, cols, data):
        return (f'{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n'
                f'   data: [ {", ".join(str(v) for v in data)} ]\n')

    k, lens, pk, plens, r, t = names
    return ('%YAML:1.0\n---\n' + matrix(k, 3, 3, [100., 0., 31.5, 0., 100., 23.5, 0., 0., 1.]) +
            matrix(lens, 1, 5, [.1, -.2, 0., 0., 1e-3]) + matrix(pk, 3, 3, [90., 0., 15., 0., 90., 11., 0., 0., 1.]) +
            matrix(plens, 5, 1, [0.] * 5) + matrix(r, 3, 3, [1., 0., 0., 0., 1., 0., 0., 0., 1.]) +
            matrix(t, 3, 1, [100., 0., 0.]) + sizes)


def opencv_xml():
    def matrix(name, rows, cols, data):
        return (f'<{name} type_id="opencv-matrix">\n  <rows>{rows}</rows>\n  <cols>{cols}</cols>\n  <dt>d</dt>\n'
                f'  <data>\n    {data}</data></{name}>\n')

    return ('<?xml version="1.0"?>\n<opencv_storage>\n' + matrix('img_shape', 2, 1, '48. 64.') +
            matrix('cam_int', 3, 3, '100. 0. 31.5 0. 100. 23.5 0. 0. 1.') + matrix('cam_dist', 1, 4, '.1 0. 0. 0.') +
            matrix('proj_int', 3, 3, '90. 0. 15. 0. 90. 11. 0. 0. 1.') + matrix('proj_dist', 1, 4, '0. 0. 0. 0.') +
            matrix('roration', 3, 3, '1. 0. 0. 0. 1. 0. 0. 0. 1.') + matrix('translation', 3, 1, '100. 0. 0.') +
            '</opencv_storage>\n')


def documents():
    yaml = opencv_yaml(('camK', 'camKc', 'prjK', 'prjKc', 'R', 'T'), 'camW: 64\ncamH: 48\nprjW: 32\nprjH: 24\n')
    other = opencv_yaml(('cam1_intrinsics', 'cam1_distorsion', 'cam2_intrinsics', 'cam2_distorsion', 'R', 'T'))
    plain = 'a: 1.5\nb: [1, two, "3", ~]\nc:\n  - d: yes\n  - - 1e3\n    - \'x\'\nlong: |\n  words\n  and more\n'
    params = ('camK: [ "9, 0, 4", "0, 9, 4", "0, 0, 1" ]\ncamKc: [ 0, 0, 0, 0, 0 ]\n'
              'prjK: [ [ 9, 0, 4 ], [ 0, 9, 4 ], [ 0, 0, 1 ] ]\nprjKc: [ 0, 0, 0, 0 ]\n'
              'camRT: [ [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0] ]\nprjRT: [ [1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0] ]\n')
    for name, text in {'opencv': yaml, 'plain': plain, 'flow': '{a: [1, {b: c}], ? d : e}\n', 'params': params}.items():
        write('yaml', name + '.yml', text)
    small = '<?xml version="1.0"?><o><a>1 2 3</a><b><_>0.1</_><_>x</_></b><c d="e">words</c><!-- no --><f/></o>'
    for name, text in {'opencv': opencv_xml(), 'small': small, 'cdata': '<a><b><![CDATA[1 2]]></b></a>'}.items():
        write('xml', name + '.xml', text)

    write('calibration', 'single.yml', yaml)
    write('calibration', 'samples.yml', other)
    write('calibration', 'params.yml', params)
    write('calibration', 'procam.xml', opencv_xml())
    write('calibration', 'camera_config.json', as_json({
        'camera': {'P': K, 'distortion': [0.1, 0, 0, 0, 0], 'width': 8, 'height': 8}}))
    write('calibration', 'cameras.json', as_json([
        {'view_id': i, 'width': 8, 'height': 8, 'K': K, 'rotation': UNIT, 'position': [0, 0, -3 - i]} for i in (1, 2)]))
    write('calibration', 'projector.json', as_json([{'width': 8, 'height': 8, 'K': K, 'R': UNIT, 'T': [0, 0, 3]}]))
    write('calibration', 'whole.json', as_json({
        'camIntrinsics': K, 'camDistCoeffs': [0, 0, 0, 0], 'projIntrinsics': K, 'projDistCoeffs': [0, 0, 0, 0],
        'R': UNIT, 'T': [1, 0, 0]}))


def nepmaps():
    frames = [{'view_id': '0000', 'file_path': 'a', 'RT': C2W, 'patterns': ['black']},
              {'view_id': '0000', 'file_path': 'b.png', 'RT': C2W, 'patterns': ['white']},
              {'file_path': './c', 'blender_matrix_world': BLENDER, 'patterns': []}]
    whole = {'K_cam': K, 'K_proj': K, 'w': 8, 'h': 8, 'frames': frames, 'blender_matrix_world_proj': BLENDER}
    write('nepmap', 'whole.json', as_json(whole))
    del whole['w'], whole['h']
    whole['frames'] = frames[:1]
    write('nepmap', 'small.json', as_json(whole))


def colmaps():
    models = {'SIMPLE_PINHOLE': '9 4 4', 'PINHOLE': '9 9 4 4', 'SIMPLE_RADIAL': '9 4 4 0.1', 'RADIAL': '9 4 4 0.1 0',
              'OPENCV': '9 9 4 4 0.1 0 0 0'}
    lines = [f'{i + 1} {model} 8 8 {numbers}\n' for i, (model, numbers) in enumerate(models.items())]
    images = ['1 1 0 0 0 0 0 3 1 calib.png\n\n', '2 1 0 0 0 1 0 3 2 a.png\n4 4 -1 5 5 2\n',
              f'3 {math.sqrt(0.5)} 0 {math.sqrt(0.5)} 0 0 1 3 5 folder/b.png\n\n']
    write('colmap', 'whole.txt', '# Camera list\n' + ''.join(lines) + '----\n# Image list\n' + ''.join(images))
    write('colmap', 'small.txt', lines[0] + '----\n' + images[0] + images[1].replace(' 2 a', ' 1 a'))


def turntables():
    write('turntable', 'angles.json', as_json({'axis': [0, -1, 0], 'point': [0, 40, 600], 'angles': [0, 45, 90]}))
    write('turntable', 'alone.json', as_json({'angles': [-360, 1e-3, 720.5]}))
    write('turntable', 'steps.yml', 'axis: [0, -1, 0]\npoint: [0, 40, 600]\ncount: 8\nstep: 45\n')


for make in (splats, pngs, jpegs, profiles, tiffs, exrs, plys, foreign_plys, safetensors, captures, configurations, documents, nepmaps, colmaps, turntables):
    make()
