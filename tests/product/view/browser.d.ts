// What browsers have and TypeScript 4.8 does not know, for test_scripts.py.
declare const ImageDecoder: any, OffscreenCanvas: any, DecompressionStream: any;
declare function queryLocalFonts(): Promise<any[]>;
declare function getScreenDetails(): Promise<any>;
interface Array<T> { findLastIndex(test: (value: T, index: number) => unknown): number; }
