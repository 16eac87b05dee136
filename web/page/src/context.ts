import type { Changes } from "./live/changes.js";
import type { Connection } from "./live/connection.js";
import type { FromServer, SceneState } from "./live/messages.js";
import type { Recorder } from "./live/recorder.js";
import type { Tables } from "./live/tables.js";

/** What desk mode and XR mode share. */
export interface Context {
  /** The scene as it now is. */
  readonly state: SceneState;
  /** The server; null for an exported page. */
  readonly connection: Connection | null;
  /** What the person changes in the scene. */
  readonly changes: Changes;
  readonly tables: Tables;
  readonly recorder: Recorder;
  /** Told every message of the server's, `state` already taken over. */
  listen(listener: (message: FromServer) => void): () => void;
}
