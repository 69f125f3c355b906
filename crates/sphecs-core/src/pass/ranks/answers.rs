//! Values that rank 0 alone has, for the keys of each rank.

use super::{Messages, Ranks};

impl Ranks {
    /// Returns a value for each key of this rank, in their order; `find` finds them, on rank 0.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn answers_of_first<K: bytemuck::Pod, V: bytemuck::Pod>(
        &self,
        keys: &[K],
        find: impl Fn(&[K]) -> Vec<V>,
    ) -> Vec<V> {
        let Some(group) = &self.group else { return find(keys) };
        let asked = self.to_first(bytemuck::cast_slice(keys).to_vec());
        let state = &mut *group.state();
        let Messages { outgoing, incoming, .. } = &mut state.messages;
        outgoing.iter_mut().chain(&mut *incoming).for_each(Vec::clear);
        if self.rank() > 0 {
            incoming[0].resize(keys.len() * size_of::<V>(), 0);
            group.exchange(state);
            return state.messages.incoming[0]
                .chunks_exact(size_of::<V>())
                .map(bytemuck::pod_read_unaligned)
                .collect();
        }
        for (message, asked) in outgoing.iter_mut().zip(&asked).skip(1) {
            let keys: Vec<K> = asked.chunks_exact(size_of::<K>()).map(bytemuck::pod_read_unaligned).collect();
            message.extend_from_slice(bytemuck::cast_slice(&find(&keys)));
        }
        group.exchange(state);
        find(keys)
    }
}
