/** A chunk of a recording that is not known to be on the server's disk. */
export interface Kept {
  readonly recording: string;
  readonly sequence: number;
  readonly bytes: ArrayBuffer;
}

const NAME = "touchwarp-recordings";

/**
 * Chunks and beginnings of recordings on this device, in IndexedDB, so that a reload or a closed
 * headset loses nothing; in memory where the browser forbids that.
 */
export class ChunkStore {
  #memory = new Map<string, unknown>();
  #database: Promise<IDBDatabase | null>;

  constructor() {
    this.#database = new Promise((resolve) => {
      try {
        const request = indexedDB.open(NAME, 1);
        request.onupgradeneeded = () => request.result.createObjectStore("kept");
        request.onsuccess = () => resolve(request.result);
        request.onerror = () => resolve(null);
      } catch {
        resolve(null);
      }
    });
  }

  async put(key: string, value: unknown): Promise<void> {
    const database = await this.#database;
    if (database === null) {
      this.#memory.set(key, value);
      return;
    }
    const transaction = database.transaction("kept", "readwrite");
    const written = done(transaction.objectStore("kept").put(value, key));
    transaction.commit(); // which a page that is being closed need not come back for
    await written;
  }

  async get<T>(key: string): Promise<T | undefined> {
    const database = await this.#database;
    if (database === null) return this.#memory.get(key) as T | undefined;
    return done(database.transaction("kept").objectStore("kept").get(key)) as Promise<
      T | undefined
    >;
  }

  async delete(key: string): Promise<void> {
    const database = await this.#database;
    if (database === null) this.#memory.delete(key);
    else await done(database.transaction("kept", "readwrite").objectStore("kept").delete(key));
  }

  /** Keys that begin so, in order. */
  async keys(prefix: string): Promise<string[]> {
    const database = await this.#database;
    if (database === null) {
      return [...this.#memory.keys()].filter((key) => key.startsWith(prefix)).sort();
    }
    const range = IDBKeyRange.bound(prefix, `${prefix}\uffff`);
    const found = database.transaction("kept").objectStore("kept").getAllKeys(range);
    return (await done(found)) as string[];
  }
}

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}
