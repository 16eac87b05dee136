import type { FromPage, FromServer } from "./messages.js";

export type Listener = (message: FromServer) => void;

/** The WebSocket to `touchwarp view`, opened again whenever it closes. */
export class Connection {
  #socket: WebSocket | null = null;
  #listeners = new Set<Listener>();
  #statusListeners = new Set<(open: boolean) => void>();
  #wait = 250;

  constructor(readonly url: string) {
    this.#open();
    addEventListener("online", () => this.#reopen());
  }

  get open(): boolean {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Told every message; returns how to stop that. */
  listen(listener: Listener): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  /** Told whenever the connection opens or closes. */
  listenStatus(listener: (open: boolean) => void): () => void {
    this.#statusListeners.add(listener);
    return () => this.#statusListeners.delete(listener);
  }

  /** Send a message; false where there is no connection just now. */
  send(message: FromPage | ArrayBuffer): boolean {
    if (!this.open) return false;
    this.#socket!.send(message instanceof ArrayBuffer ? message : JSON.stringify(message));
    return true;
  }

  #open(): void {
    const socket = new WebSocket(this.url);
    this.#socket = socket;
    socket.onopen = () => {
      this.#wait = 250;
      for (const listener of this.#statusListeners) listener(true);
    };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data as string) as FromServer;
      for (const listener of this.#listeners) listener(message);
    };
    socket.onclose = () => {
      if (this.#socket !== socket) return;
      for (const listener of this.#statusListeners) listener(false);
      setTimeout(() => this.#socket === socket && this.#open(), this.#wait);
      this.#wait = Math.min(2 * this.#wait, 4000);
    };
  }

  #reopen(): void {
    this.#wait = 250;
    if (this.#socket?.readyState === WebSocket.CLOSED) this.#open();
  }
}
